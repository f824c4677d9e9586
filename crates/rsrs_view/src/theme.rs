//! Where a picture is looked at.

/// Where a picture is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Theme {
    /// On a screen, alone: it names what it shows.
    #[default]
    Screen,
    /// In a paper, above a caption: without title, facts and notes, which are in the file, and with a legend
    /// of few lines.
    Paper,
}

impl Theme {
    /// What the file holds of the texts that the picture does not show: those that stand above and
    /// below it on a screen, and details that are in the file in any case.
    pub(crate) fn description<'a>(
        self,
        texts: impl IntoIterator<Item = &'a str>,
        details: &'a str,
    ) -> String {
        let hidden = texts.into_iter().filter(|_| self == Self::Paper);
        let all = hidden.chain(std::iter::once(details)).filter(|text| !text.is_empty());
        all.collect::<Vec<_>>().join(". ")
    }
}

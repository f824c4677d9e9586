//! How wide a text is, in the font that the pictures are made for.

/// Thickness of the letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Ordinary letters.
    Regular,
    /// Bold letters.
    Bold,
}

/// Advances of the characters from space to tilde, in thousandths of the font size; see
/// `fonts/README.md`.
#[rustfmt::skip]
const REGULAR: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337,
    636, 636, 636, 636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531,
    1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656, 557, 863, 748, 787,
    603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500,
    500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612,
    635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
];

#[rustfmt::skip]
const BOLD: [u16; 95] = [
    348, 456, 521, 838, 696, 1002, 872, 306, 457, 457, 523, 838, 380, 415, 380, 365,
    696, 696, 696, 696, 696, 696, 696, 696, 696, 696, 400, 400, 838, 838, 838, 580,
    1000, 774, 762, 734, 830, 683, 683, 821, 837, 372, 372, 775, 637, 995, 837, 850,
    733, 850, 770, 720, 682, 812, 774, 1103, 771, 724, 725, 457, 365, 457, 838, 500,
    500, 675, 716, 593, 716, 678, 435, 716, 712, 343, 343, 665, 343, 1042, 712, 687,
    716, 716, 493, 595, 478, 712, 652, 924, 645, 652, 582, 712, 365, 712, 838,
];

/// Width of a line of text, in pixels.
///
/// Characters outside ASCII count as wide ones, so that a text is never wider than this returns by
/// much; the middle dot that separates facts is counted exactly.
pub fn width_px(text: &str, size_px: f64, weight: Weight) -> f64 {
    let table = match weight {
        Weight::Regular => &REGULAR,
        Weight::Bold => &BOLD,
    };
    let thousandths: u32 = text.chars().map(|character| advance(table, character)).sum();
    f64::from(thousandths) * size_px / 1000.0
}

fn advance(table: &[u16; 95], character: char) -> u32 {
    match character {
        ' '..='~' => u32::from(table[character as usize - ' ' as usize]),
        '·' => u32::from(table[0]),
        '–' | '°' | '²' | '³' | '¹' => 500,
        _ => 840,
    }
}

/// Breaks a text into lines of at most a given width, between words where possible; a word that is
/// wider than a line is cut. A text without words has no lines.
pub fn wrap(text: &str, size_px: f64, weight: Weight, room_px: f64) -> Vec<String> {
    let fits = |line: &str| width_px(line, size_px, weight) <= room_px;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        if let Some(line) = lines.last_mut()
            && fits(&format!("{line} {word}"))
        {
            line.push(' ');
            line.push_str(word);
            continue;
        }
        let mut piece = String::new();
        for character in word.chars() {
            if !piece.is_empty() && !fits(&format!("{piece}{character}")) {
                lines.push(std::mem::take(&mut piece));
            }
            piece.push(character);
        }
        lines.push(piece);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::width_of_rendered_text_px;

    #[test]
    fn widths_are_those_of_the_embedded_font() {
        for (weight, name) in [(Weight::Regular, "normal"), (Weight::Bold, "bold")] {
            let text = "Ring: 0.15 m/s, 0.75 rad/s (N = 9) · semi-stable WAVE @#{}";

            let rendered_px = width_of_rendered_text_px(text, 20.0, name);
            let computed_px = width_px(text, 20.0, weight);

            // Kerning and the white space around the first and last letter are not in the table.
            assert!((rendered_px - computed_px).abs() < 0.02 * computed_px, "{rendered_px}");
        }
    }

    #[test]
    fn lines_break_between_words_and_long_words_are_cut() {
        let lines = wrap("one two  threefourfive", 10.0, Weight::Regular, 45.0);

        assert_eq!(lines, ["one two", "threefou", "rfive"]);
        assert!(wrap(" ", 10.0, Weight::Regular, 45.0).is_empty());
        assert_eq!(wrap("ab", 10.0, Weight::Regular, 1.0), ["a", "b"], "no letter fits");
    }
}

//! `cells.csv`: one line for each cell, written and read back.

use anyhow::{Context, bail};
use rsrs_core::diagram::DiagramCell;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::columns::{AS_MEASURED, INTERVAL_COLUMN, N_COLUMN, SHARE_COLUMNS};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::statistics::interval_kind::IntervalKind;
use rsrs_core::statistics::share::Share;

use crate::sweep::result::SweepResult;

/// The cells of a file, by world.
pub struct Cells {
    /// With the robots that the sweep makes worse.
    pub simulated: Vec<DiagramCell>,
    /// With the robots as measured; `None` where the file does not have them.
    pub as_measured: Option<Vec<DiagramCell>>,
}

/// Axes, number of replicates, one count for each phase, majority, share of stable milling with its
/// interval; all but the axes again for the robots as measured, if they are others; where cells have
/// different numbers of replicates, also the kind of the interval.
pub fn to_csv(result: &SweepResult) -> Vec<u8> {
    let kind = result.source.sweep.interval_kind();
    let behaviour = result.source.sweep.behaviour.known();
    let axes = result.diagram.axes.iter().map(|axis| axis.key().to_owned());
    let mut columns: Vec<String> = axes.chain(count_columns(behaviour, "")).collect();
    if result.as_measured.is_some() {
        columns.extend(count_columns(behaviour, AS_MEASURED));
    }
    columns.extend(kind_column(kind).map(|(name, _)| name.to_owned()));
    let mut rows = vec![columns];
    for (index, DiagramCell { cell, counts }) in result.diagram.cells.iter().enumerate() {
        let mut fields: Vec<String> = cell.iter().map(|(_, value)| value.to_string()).collect();
        fields.extend(count_fields(behaviour, counts, kind));
        if let Some(measured) = &result.as_measured {
            fields.extend(count_fields(behaviour, &measured.cells[index].counts, kind));
        }
        fields.extend(kind_column(kind).map(|(_, key)| key.to_owned()));
        rows.push(fields);
    }
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.write_record(row).expect("memory takes rows of one width");
    }
    csv.into_inner().expect("memory takes all")
}

/// The columns of one world.
fn count_columns(behaviour: Behaviour, prefix: &str) -> impl Iterator<Item = String> {
    let phases = behaviour.phases().iter().map(|phase| phase.key());
    let names = [N_COLUMN].into_iter().chain(phases).chain(SHARE_COLUMNS);
    names.map(move |name| format!("{prefix}{name}"))
}

/// The fields of [`count_columns`].
fn count_fields(
    behaviour: Behaviour,
    counts: &PhaseCounts,
    kind: IntervalKind,
) -> impl Iterator<Item = String> {
    let share = Share::milling(counts);
    let interval = kind.interval(share.hits, share.n);
    let numbers = std::iter::once(counts.total())
        .chain(behaviour.phases().iter().map(|phase| counts.get(*phase)))
        .map(|number| number.to_string());
    let phase = counts.majority().map_or("", Phase::key).to_owned();
    let shares = [share.value(), interval.low, interval.high].map(|share| format!("{share:.6}"));
    let numbers: Vec<String> = numbers.collect();
    numbers.into_iter().chain([phase]).chain(shares)
}

/// The last column of adaptive sweeps, with its value.
fn kind_column(kind: IntervalKind) -> Option<(&'static str, &'static str)> {
    (kind != IntervalKind::ClopperPearson).then(|| (INTERVAL_COLUMN, kind.key()))
}

/// Reads what [`to_csv`] wrote, or an earlier version of it, which had one world only.
pub fn from_csv(
    text: &str,
    axes: &[Axis],
    (behaviour, kind): (Behaviour, IntervalKind),
) -> anyhow::Result<Cells> {
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let header = rows.headers()?;
    let has_both = header.iter().any(|name| name.starts_with(AS_MEASURED));
    let n_counts = count_columns(behaviour, "").count();
    let n_simulated = axes.len() + n_counts;
    let n_worlds = if has_both { n_simulated + n_counts } else { n_simulated };
    let n_columns = n_worlds + kind_column(kind).iter().len();
    if header.len() != n_columns {
        bail!("line 1: found {} columns, expected {n_columns}", header.len());
    }
    let mut cells = Cells { simulated: Vec::new(), as_measured: has_both.then(Vec::new) };
    for row in rows.records() {
        let row = row?;
        let fields: Vec<&str> = row.iter().collect();
        let (values, counts) = fields.split_at(axes.len());
        let read = |counts: &[&str]| {
            read_cell((axes, values), behaviour, counts)
                .with_context(|| format!("line {}", row.position().map_or(0, csv::Position::line)))
        };
        cells.simulated.push(read(counts)?);
        if let Some(measured) = &mut cells.as_measured {
            measured.push(read(&fields[n_simulated..])?);
        }
    }
    Ok(cells)
}

/// A cell of these axes from its values and its counts, which begin with their sum.
fn read_cell(
    (axes, values): (&[Axis], &[&str]),
    behaviour: Behaviour,
    rest: &[&str],
) -> anyhow::Result<DiagramCell> {
    let number = |text: &&str| text.parse::<f64>().with_context(|| format!("`{text}`"));
    let values = values.iter().map(number).collect::<anyhow::Result<Vec<f64>>>()?;
    let mut counts = PhaseCounts::default();
    for (phase, field) in behaviour.phases().iter().zip(&rest[1..]) {
        let n: u64 = field.parse().with_context(|| format!("`{field}` as a count"))?;
        counts.add_many(*phase, n);
    }
    Ok(DiagramCell { cell: Cell::new(axes.iter().copied().zip(values))?, counts })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> anyhow::Result<Cells> {
        let kind = (Behaviour::MILLING, IntervalKind::ClopperPearson);
        from_csv(text, &[Axis::Speed], kind)
    }

    fn header() -> String {
        let columns: Vec<String> = count_columns(Behaviour::MILLING, "").collect();
        format!("speed_m_s,{}\n", columns.join(","))
    }

    fn row(speed_m_s: &str) -> String {
        let counts = Behaviour::MILLING.phases().iter().map(|_| "4").collect::<Vec<_>>();
        let n = 4 * counts.len();
        format!("{speed_m_s},{n},{},dispersion,0.25,0.1,0.5\n", counts.join(","))
    }

    #[test]
    fn what_a_spreadsheet_has_quoted_is_read() {
        let cells = read(&format!("{}{}", header(), row("\"0.15\""))).unwrap().simulated;

        assert_eq!(cells[0].cell.get(Axis::Speed), Some(0.15));
        assert_eq!(cells[0].counts.get(Phase::STABLE_MILLING), 4);
    }

    #[test]
    fn what_is_wrong_has_its_line() {
        let error = |rows: &str| {
            let error = read(&format!("{}{}{rows}", header(), row("0.1"))).err();
            format!("{:#}", error.expect("it is refused"))
        };

        let number = error(&row("fast"));
        let width = error("0.15,4\n");
        let other = format!("{:#}", read("speed_m_s,n\n0.1,4\n").err().expect("it is refused"));

        assert!(number.starts_with("line 3: `fast`"), "{number}");
        assert!(width.contains("line: 3") && width.contains("2 fields"), "{width}");
        assert!(other.starts_with("line 1: found 2 columns, expected"), "{other}");
    }
}

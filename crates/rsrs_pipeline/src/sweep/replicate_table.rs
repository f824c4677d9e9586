//! The tidy table of replicates: one row each, as Parquet.

use std::collections::HashMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::record::Field;
use parquet::schema::parser::parse_message_type;
use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::diagram::folder::REPLICATES;
use rsrs_core::judge::order::Parameter;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_sim::sweep::ReplicateOutcome;

use crate::files::cannot_write;
use crate::sweep::result::{SweepResult, World};

/// The mean of one order parameter over the runs of each cell in a world, in the order of the
/// diagram; of a radius, over those that ended as wanted. `None` where no run of a cell has a
/// number.
pub fn means(
    folder: &Path,
    result: &SweepResult,
    world: World,
    key: &str,
) -> anyhow::Result<Vec<Option<f64>>> {
    let path = folder.join(REPLICATES);
    let what = || format!("cannot read {}", path.display());
    let file = File::open(&path).with_context(what)?;
    let reader = SerializedFileReader::new(file).with_context(what)?;
    let diagram = result.of_world(world)?;
    let index = index_of_cells(diagram);
    let wanted = result.source.sweep.behaviour.known().wanted().key();
    // Where robots are not made worse, all runs are of robots as measured.
    let is_one = result.source.as_measured().is_none();
    let world = if is_one { World::AsMeasured } else { world };
    let mut sums = vec![(0.0, 0_u64); diagram.cells.len()];
    for row in reader.get_row_iter(None).with_context(what)? {
        let row = row.with_context(what)?;
        let mut at = Vec::new();
        let (mut value, mut is_counted) = (None, true);
        for (name, field) in row.get_column_iter() {
            match field {
                Field::Double(number) if name == key => value = Some(*number),
                Field::Double(number) if diagram.axes.iter().any(|axis| axis.key() == name) => {
                    at.push(number.to_bits());
                }
                Field::Str(text) if name == "world" => is_counted &= text == world.key(),
                Field::Str(text) if name == "phase" && key.ends_with("_m") => {
                    is_counted &= text == wanted;
                }
                _ => {}
            }
        }
        if let (Some(value), Some(cell)) = (value.filter(|_| is_counted), index.get(&at)) {
            sums[*cell].0 += value;
            sums[*cell].1 += 1;
        }
    }
    Ok(sums.into_iter().map(|(sum, n)| (n > 0).then(|| sum / n as f64)).collect())
}

/// The places of cells in a diagram, by the bits of their values on its axes.
fn index_of_cells(diagram: &PhaseDiagram) -> HashMap<Vec<u64>, usize> {
    let key = |cell: &Cell| -> Option<Vec<u64>> {
        diagram.axes.iter().map(|axis| cell.get(*axis).map(f64::to_bits)).collect()
    };
    let cells = diagram.cells.iter().enumerate();
    cells.filter_map(|(index, entry)| Some((key(&entry.cell)?, index))).collect()
}

/// Rows of a group: as many as are held in memory.
const GROUP_ROWS: usize = 65_536;

/// A table that is being written: one row for each replicate with axes, number, seed, phase, order
/// parameters, and which world it is of.
///
/// Its bytes follow from its rows, however they are appended, and so does its memory: that of one
/// group of rows.
pub struct ReplicateTable<'a> {
    path: &'a Path,
    diagram: &'a PhaseDiagram,
    seed: u64,
    /// That of the first as many rows as there are cells, and that of the next.
    worlds: Vec<World>,
    /// Those of the behaviour.
    parameters: Vec<Parameter>,
    writer: SerializedFileWriter<File>,
    rows: Vec<ReplicateOutcome>,
}

impl<'a> ReplicateTable<'a> {
    /// Begins a table. Its outcomes refer to the cells of the sweep by index, first to those of
    /// robots made worse, and from there on to those of robots as measured.
    pub fn create(path: &'a Path, result: &'a SweepResult) -> anyhow::Result<Self> {
        let (diagram, seed) = (&result.diagram, result.source.sweep.seed);
        let worlds = match result.source.as_measured() {
            Some(_) => vec![World::Harsher, World::AsMeasured],
            None => vec![World::AsMeasured],
        };
        let parameters = Parameter::of_behaviour(result.source.sweep.behaviour.known());
        let properties = WriterProperties::builder()
            .set_created_by("rsrs".to_owned())
            .set_compression(parquet::basic::Compression::SNAPPY)
            .set_max_row_group_row_count(Some(GROUP_ROWS))
            .build();
        let schema = parse_message_type(&schema(&diagram.axes, &parameters))
            .context("schema of the rows")?;
        let file = File::create(path).with_context(|| cannot_write(path))?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
            .with_context(|| cannot_write(path))?;
        Ok(Self { path, diagram, seed, worlds, parameters, writer, rows: Vec::new() })
    }

    /// Appends rows.
    pub fn append(&mut self, outcomes: &[ReplicateOutcome]) -> anyhow::Result<()> {
        // In pieces that fit into a group, of which there is no second copy.
        let mut left = outcomes;
        while !left.is_empty() {
            let n = left.len().min(GROUP_ROWS - self.rows.len());
            let (now, later) = left.split_at(n);
            self.rows.extend_from_slice(now);
            left = later;
            if self.rows.len() == GROUP_ROWS {
                let mut group = std::mem::take(&mut self.rows);
                self.write_group(&group).with_context(|| cannot_write(self.path))?;
                group.clear();
                self.rows = group;
            }
        }
        Ok(())
    }

    /// Writes what is left, and the file's end.
    pub fn finish(mut self) -> anyhow::Result<()> {
        let group = std::mem::take(&mut self.rows);
        if !group.is_empty() {
            self.write_group(&group).with_context(|| cannot_write(self.path))?;
        }
        self.writer.close().with_context(|| cannot_write(self.path))?;
        Ok(())
    }

    fn write_group(&mut self, rows: &[ReplicateOutcome]) -> anyhow::Result<()> {
        let (diagram, seed) = (self.diagram, self.seed);
        let n_cells = diagram.cells.len();
        let phases: Vec<ByteArray> = rows.iter().map(|row| row.phase.key().into()).collect();
        let world = |row: &ReplicateOutcome| self.worlds[row.cell / n_cells].key().into();
        let worlds: Vec<ByteArray> = rows.iter().map(world).collect();
        let replicates: Vec<i64> = rows.iter().map(|row| row.replicate.cast_signed()).collect();
        let seeds = vec![seed.cast_signed(); rows.len()];
        let mut group = self.writer.next_row_group()?;
        for axis in &diagram.axes {
            let value = |row: &ReplicateOutcome| {
                let cell = &diagram.cells[row.cell % n_cells].cell;
                cell.get(*axis).expect("every cell has every axis")
            };
            let values: Vec<f64> = rows.iter().map(value).collect();
            write_column::<DoubleType>(&mut group, &values, None)?;
        }
        for numbers in [&replicates, &seeds] {
            write_column::<Int64Type>(&mut group, numbers, None)?;
        }
        write_column::<ByteArrayType>(&mut group, &phases, None)?;
        for parameter in &self.parameters {
            let values: Vec<_> = rows.iter().map(|row| parameter.value(&row.evidence)).collect();
            let present: Vec<f64> = values.iter().copied().flatten().collect();
            let levels: Vec<i16> = values.iter().map(|it| i16::from(it.is_some())).collect();
            write_column::<DoubleType>(&mut group, &present, Some(&levels))?;
        }
        write_column::<ByteArrayType>(&mut group, &worlds, None)?;
        group.close()?;
        Ok(())
    }
}

fn schema(axes: &[Axis], parameters: &[Parameter]) -> String {
    let axes = axes.iter().map(|axis| format!("required double {axis};"));
    let fixed = [
        "required int64 replicate;".to_owned(),
        "required int64 seed;".to_owned(),
        "required binary phase (utf8);".to_owned(),
    ];
    let columns = parameters.iter().map(|it| format!("optional double {it};"));
    let world = ["required binary world (utf8);".to_owned()];
    let fields: Vec<String> = axes.chain(fixed).chain(columns).chain(world).collect();
    format!("message replicate {{ {} }}", fields.join(" "))
}

fn write_column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, File>,
    values: &[T::T],
    are_present: Option<&[i16]>,
) -> anyhow::Result<()> {
    let mut column = group.next_column()?.context("a column for each of the schema")?;
    column.typed::<T>().write_batch(values, are_present, None)?;
    Ok(column.close()?)
}

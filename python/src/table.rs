//! Tables, which polars, pandas, pyarrow and duckdb read without a copy by the C interface of Arrow.

use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi::FFI_ArrowSchema;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int64Type, UInt64Type};
use arrow_array::{
    Array, ArrayRef, Float64Array, RecordBatch, RecordBatchIterator, RecordBatchReader,
    StringArray, UInt64Array,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use numpy::IntoPyArray;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList};

use crate::error::{our_mistake, refused};
use crate::folder::Folder;

/// A table: give it to `polars.DataFrame`, `pandas.DataFrame.from_arrow`, `pyarrow.table` or duckdb, or take
/// it as a dictionary of numpy arrays.
#[pyclass(name = "Table", module = "rsrs", frozen)]
pub struct Table {
    source: Source,
    schema: SchemaRef,
    n_rows: usize,
}

enum Source {
    Batch(RecordBatch),
    /// A file of Parquet; the folder is kept as long as the table.
    File(PathBuf, #[expect(dead_code, reason = "keeps the folder")] Arc<Folder>),
}

/// Columns of a table that is being made.
#[derive(Default)]
pub struct Columns {
    fields: Vec<Field>,
    arrays: Vec<ArrayRef>,
}

impl Columns {
    fn add(&mut self, name: impl Into<String>, array: ArrayRef) {
        let is_nullable = array.null_count() > 0;
        self.fields.push(Field::new(name, array.data_type().clone(), is_nullable));
        self.arrays.push(array);
    }

    /// A column of doubles.
    pub fn doubles(&mut self, name: impl Into<String>, values: Vec<f64>) {
        self.add(name, Arc::new(Float64Array::from(values)));
    }

    /// A column of doubles of which some are not known.
    pub fn optional_doubles(&mut self, name: impl Into<String>, values: Vec<Option<f64>>) {
        self.add(name, Arc::new(Float64Array::from(values)));
    }

    /// A column of counts.
    pub fn counts(&mut self, name: impl Into<String>, values: Vec<u64>) {
        self.add(name, Arc::new(UInt64Array::from(values)));
    }

    /// A column of words of which some may be missing.
    pub fn words<T: AsRef<str>>(&mut self, name: impl Into<String>, values: Vec<Option<T>>) {
        let array: StringArray = values.into_iter().collect();
        self.add(name, Arc::new(array));
    }

    /// The table.
    pub fn table(self) -> PyResult<Table> {
        let schema = Arc::new(Schema::new(self.fields));
        let batch = RecordBatch::try_new(schema.clone(), self.arrays).map_err(our_mistake)?;
        Ok(Table { n_rows: batch.num_rows(), source: Source::Batch(batch), schema })
    }
}

impl Table {
    /// A file of Parquet in a folder.
    pub fn file(folder: &Arc<Folder>, name: &str) -> PyResult<Self> {
        let path = folder.path.join(name);
        let builder = open(&path)?;
        let n_rows = builder.metadata().file_metadata().num_rows();
        Ok(Self {
            schema: builder.schema().clone(),
            n_rows: usize::try_from(n_rows).map_err(our_mistake)?,
            source: Source::File(path, folder.clone()),
        })
    }

    fn reader(&self) -> PyResult<Box<dyn RecordBatchReader + Send>> {
        Ok(match &self.source {
            Source::Batch(batch) => {
                Box::new(RecordBatchIterator::new([Ok(batch.clone())], self.schema.clone()))
            }
            Source::File(path, _) => Box::new(open(path)?.build().map_err(refused)?),
        })
    }
}

fn open(path: &PathBuf) -> PyResult<ParquetRecordBatchReaderBuilder<File>> {
    let cannot =
        |error: &dyn std::fmt::Display| refused(format!("cannot read {}: {error}", path.display()));
    let file = File::open(path).map_err(|error| cannot(&error))?;
    ParquetRecordBatchReaderBuilder::try_new(file).map_err(|error| cannot(&error))
}

#[pymethods]
impl Table {
    /// The names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.schema.fields().iter().map(|field| field.name().clone()).collect()
    }
    fn __len__(&self) -> usize {
        self.n_rows
    }
    /// A dictionary of numpy arrays, one for each column; what is not known is NaN, or None among words.
    fn to_numpy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let batches: Vec<RecordBatch> =
            self.reader()?.collect::<Result<_, ArrowError>>().map_err(refused)?;
        let dict = PyDict::new(py);
        for (index, field) in self.schema.fields().iter().enumerate() {
            let parts = batches.iter().map(|batch| batch.column(index));
            dict.set_item(field.name(), to_numpy(py, field.data_type(), parts)?)?;
        }
        Ok(dict)
    }
    /// The table for others: the PyCapsule interface of Arrow.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // Nobody need be given another schema than the table has.
        let _ = requested_schema;
        let stream = FFI_ArrowArrayStream::new(self.reader()?);
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }
    /// Names and types of the columns for others.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.schema.as_ref()).map_err(our_mistake)?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }
    fn __repr__(&self) -> String {
        format!("Table({} rows: {})", self.n_rows, self.columns().join(", "))
    }
}

/// The values of one column.
fn to_numpy<'a, 'py>(
    py: Python<'py>,
    kind: &DataType,
    parts: impl Iterator<Item = &'a ArrayRef>,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(match kind {
        DataType::Float64 => {
            let values = parts.flat_map(|part| part.as_primitive::<Float64Type>().iter());
            let values: Vec<f64> = values.map(|value| value.unwrap_or(f64::NAN)).collect();
            values.into_pyarray(py).into_any()
        }
        DataType::Int64 => {
            let values = parts.flat_map(|part| part.as_primitive::<Int64Type>().values().iter());
            values.copied().collect::<Vec<i64>>().into_pyarray(py).into_any()
        }
        DataType::UInt64 => {
            let values = parts.flat_map(|part| part.as_primitive::<UInt64Type>().values().iter());
            values.copied().collect::<Vec<u64>>().into_pyarray(py).into_any()
        }
        DataType::Utf8 => {
            let words: Vec<Option<&str>> =
                parts.flat_map(|part| part.as_string::<i32>().iter()).collect();
            let list = PyList::new(py, words)?;
            py.import("numpy")?.call_method1("array", (list, "object"))?
        }
        other => return Err(our_mistake(format!("no column is of {other}"))),
    })
}

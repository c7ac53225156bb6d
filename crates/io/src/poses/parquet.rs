//! Tables of poses as Apache Parquet, which pandas, Polars and DuckDB read by column.
//!
//! Columns and their order are those of [`PoseColumns`]: `t_us` an integer, `origin` and `frame` text, all others
//! doubles, null where there is no value. Values are those of the text: both tables say the same.

#[cfg(feature = "parquet")]
use super::PoseColumns;
use super::format::PoseFormat;

/// The format.
pub(super) static FORMAT: PoseFormat = PoseFormat {
    name: "parquet",
    summary: "Apache Parquet, the columns of `table` (feature `parquet`)",
    endings: &["parquet"],
    detect: |start| start.starts_with(b"PAR1"),
    #[cfg(feature = "parquet")]
    read: columns::read,
    #[cfg(not(feature = "parquet"))]
    read: |path, _| {
        Err(crate::IoError::unwritable(path, "a table of Parquet needs the feature `parquet`"))
    },
    #[cfg(feature = "parquet")]
    write: Some(|path, kind, frame, poses| {
        columns::write(path, PoseColumns::of_frame(kind, frame), poses)
    }),
    #[cfg(not(feature = "parquet"))]
    write: None,
};

#[cfg(feature = "parquet")]
mod columns {
    use std::io::Error;
    use std::path::Path;
    use std::sync::Arc;

    use evpose_core::AtomicFile;
    use parquet::basic::{LogicalType, Repetition, Type as Physical};
    use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
    use parquet::errors::ParquetError;
    use parquet::file::properties::WriterProperties;
    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
    use parquet::record::Field;
    use parquet::schema::types::Type;

    use super::PoseColumns;
    use crate::IoError;
    use crate::poses::PoseSequence;
    use crate::poses::format::PoseIterator;
    use crate::poses::table;

    /// Rows that are in memory together.
    const GROUP: usize = 1 << 15;

    /// The physical type of a column.
    fn physical(name: &str) -> Physical {
        match name {
            "t_us" => Physical::INT64,
            "origin" | "frame" => Physical::BYTE_ARRAY,
            _ => Physical::DOUBLE,
        }
    }

    pub(super) fn write(
        path: &Path,
        columns: PoseColumns,
        poses: PoseIterator<'_>,
    ) -> Result<(), IoError> {
        let mut write = || -> Result<(), Error> {
            let mut file = AtomicFile::create(path)?;
            write_table(&mut file, columns, poses).map_err(Error::other)?;
            file.commit()
        };
        write().map_err(|source| IoError::file(path, "write", source))
    }

    fn write_table(
        file: &mut AtomicFile,
        columns: PoseColumns,
        poses: PoseIterator<'_>,
    ) -> Result<(), ParquetError> {
        let header = columns.header();
        let names: Vec<&str> = header.trim_end().split(',').collect();
        let column = |name: &&str| {
            let of = physical(name);
            let mut column = Type::primitive_type_builder(name, of);
            column = column.with_repetition(Repetition::OPTIONAL);
            if of == Physical::BYTE_ARRAY {
                column = column.with_logical_type(Some(LogicalType::String));
            }
            column.build().map(Arc::new)
        };
        let fields = names.iter().map(column).collect::<Result<Vec<_>, _>>()?;
        let schema = Arc::new(Type::group_type_builder("poses").with_fields(fields).build()?);
        let mut writer =
            SerializedFileWriter::new(file, schema, Arc::new(WriterProperties::new()))?;
        let mut poses = poses.peekable();
        // Group by group, so that memory does not grow with the recording.
        while poses.peek().is_some() {
            let mut lines = String::new();
            poses.by_ref().take(GROUP).for_each(|pose| columns.push_line(&mut lines, &pose));
            // Columns are cut from the text of the table, so that both formats round alike.
            let rows: Vec<Vec<&str>> =
                lines.lines().map(|line| line.split(',').collect()).collect();
            let mut group = writer.next_row_group()?;
            for (index, name) in names.iter().enumerate() {
                let cells = rows.iter().map(|row| row[index]);
                match physical(name) {
                    Physical::INT64 => {
                        add::<Int64Type>(&mut group, cells, |cell| cell.parse().ok())?;
                    }
                    Physical::DOUBLE => {
                        add::<DoubleType>(&mut group, cells, |cell| cell.parse().ok())?;
                    }
                    _ => {
                        let text = |cell: &str| (!cell.is_empty()).then(|| ByteArray::from(cell));
                        add::<ByteArrayType>(&mut group, cells, text)?;
                    }
                }
            }
            group.close()?;
        }
        writer.finish().map(drop)
    }

    /// Writes the next column; a cell without a value is null.
    fn add<'a, T: DataType>(
        group: &mut SerializedRowGroupWriter<'_, &mut AtomicFile>,
        cells: impl Iterator<Item = &'a str>,
        parse: impl Fn(&str) -> Option<T::T>,
    ) -> Result<(), ParquetError> {
        let cells: Vec<Option<T::T>> = cells.map(parse).collect();
        let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
        let values: Vec<T::T> = cells.into_iter().flatten().collect();
        let mut column = group.next_column()?.ok_or(ParquetError::EOF("no column".to_owned()))?;
        column.typed::<T>().write_batch(&values, Some(&levels), None)?;
        column.close()
    }

    pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<PoseSequence, IoError> {
        let table =
            table_of(bytes).map_err(|error| IoError::unwritable(path, error.to_string()))?;
        table::read(path, table.as_bytes())
    }

    /// The same table as text.
    fn table_of(bytes: &[u8]) -> Result<String, ParquetError> {
        let reader = SerializedFileReader::new(bytes::Bytes::copy_from_slice(bytes))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let names: Vec<&str> = schema.columns().iter().map(|column| column.name()).collect();
        let mut text = names.join(",") + "\n";
        for row in reader.get_row_iter(None)? {
            let row = row?;
            let cell = |field: &Field| match field {
                Field::Null => String::new(),
                Field::Str(text) => text.clone(),
                other => other.to_string(),
            };
            let cells: Vec<String> = row.get_column_iter().map(|(_, field)| cell(field)).collect();
            text += &(cells.join(",") + "\n");
        }
        Ok(text)
    }
}

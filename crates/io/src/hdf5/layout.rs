//! Detection of the datasets of events in a file, and their attributes.

use std::sync::Arc;

use evpose_core::SensorSize;
use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, Hdf5File};

use super::bytes::Bytes;
use super::number::Number;
use super::table::{Damage, Table};
use crate::names::{Places, places};
use crate::npz::REQUIRED;
use crate::sniff::{ORDERS, fitting_orders};
use crate::{ColumnNames, Header, OpenOptions, TimeUnit};

/// A place of events in a file.
struct Place {
    path: &'static str,
    /// Program whose files have it.
    layout: &'static str,
    /// The sensor they are of, where they do not say.
    usual_sensor: Option<SensorSize>,
}

const fn place(path: &'static str, layout: &'static str, size: (u16, u16)) -> Place {
    let (width, height) = size;
    let usual_sensor = if width > 0 { Some(SensorSize { width, height }) } else { None };
    Place { path, layout, usual_sensor }
}

/// All places, the likeliest first. Several of one file are its cameras.
const PLACES: &[Place] = &[
    place("CD/events", "Prophesee", (0, 0)),
    place("events", "table", (0, 0)),
    place("davis/left/events", "MVSEC", (346, 260)),
    place("davis/right/events", "MVSEC", (346, 260)),
    place("prophesee/left", "M3ED", (1280, 720)),
    place("prophesee/right", "M3ED", (1280, 720)),
    place("", "table", (0, 0)),
];
/// Dataset that DSEC's files have beside their events, and their sensor.
const DSEC: (&str, &str, SensorSize) =
    ("ms_to_idx", "DSEC", SensorSize { width: 640, height: 480 });
/// Added to all times.
const T_OFFSET: &str = "t_offset";
/// Path of the edges of external signals in Prophesee's files.
const TRIGGERS: &str = "EXT_TRIGGER/events";
/// Attributes that are worth showing: our name, theirs.
const FACTS: [(&str, &str); 4] = [
    ("date", "date"),
    ("camera", "integrator_name"),
    ("serial", "serial_number"),
    ("version", "version"),
];
/// Rows by which the order of columns without names is detected.
const LOOKED_AT: u64 = 4096;

/// A column of the events of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    /// The table that it is of.
    pub(super) table: usize,
    pub(super) number: Number,
}

/// The events of a file.
pub(super) struct Layout {
    pub(super) tables: Vec<Table>,
    /// Times, columns, rows and polarities of the events.
    pub(super) columns: [Column; 4],
    pub(super) t_offset: i64,
    /// Unit that the name of times states.
    pub(super) unit: Option<TimeUnit>,
    pub(super) header: Header,
    pub(super) remarks: Vec<String>,
}

/// Error of a file without events that can be read.
pub(super) enum LayoutError {
    /// A damaged or unknown structure.
    Structure(Error),
    /// Damaged first rows.
    Rows(Damage),
    /// A camera that the file lacks.
    Camera(String),
}

impl From<Error> for LayoutError {
    fn from(error: Error) -> Self {
        Self::Structure(error)
    }
}

/// Object at a path.
enum Node {
    Group(Group),
    Dataset(Box<Dataset>),
}

/// Finds the events of a file.
pub(super) fn find(
    file: &Hdf5File,
    bytes: &Arc<Bytes>,
    options: &OpenOptions,
) -> Result<Layout, LayoutError> {
    let root = file.root_group()?;
    let mut cameras = Vec::new();
    // In this order of cameras, which options count from 0.
    for place in PLACES {
        if let Some(node) = at(&root, place.path)?
            && is_events(&node, &options.columns)?
        {
            cameras.push((place, node));
        }
    }
    let camera = usize::from(options.camera.unwrap_or(0));
    // The message lists what the file has instead.
    if cameras.is_empty() {
        let (groups, datasets) = root.member_names()?;
        let names = [groups, datasets].concat().join(", ");
        return Err(Error::Other(format!("no events in any known place (it has: {names})")).into());
    }
    if camera >= cameras.len() {
        return Err(LayoutError::Camera(format!("no camera {camera}, it has {}", cameras.len())));
    }
    // A second camera is passed over, but not in silence.
    let mut remarks = Vec::new();
    let others =
        cameras.iter().enumerate().filter(|(k, _)| *k != camera && options.camera.is_none());
    remarks.extend(others.map(|(k, (place, _))| {
        format!("the events of /{} are passed over: they are those of camera {k}", place.path)
    }));
    let (place, node) = cameras.swap_remove(camera);
    let (tables, columns, unit) = match &node {
        Node::Group(group) => of_group(file, bytes, group, &options.columns)?,
        Node::Dataset(dataset) => of_dataset(file, bytes, dataset, &options.columns)?,
    };
    if let Some(Node::Dataset(triggers)) = at(&root, TRIGGERS)?
        && triggers.num_elements()? > 0
    {
        let count = triggers.num_elements()?;
        remarks.push(format!("{count} edges of external signals are passed over"));
    }
    let is_dsec = matches!(at(&root, DSEC.0)?, Some(Node::Dataset(_)));
    let (layout, usual_sensor) = match is_dsec {
        true => (DSEC.1, Some(DSEC.2)),
        false => (place.layout, place.usual_sensor),
    };
    let packing = tables.first().map(Table::filters).filter(|names| !names.is_empty());
    let mut facts = vec![("layout", format!("{layout}, /{}", place.path))];
    facts.push(("packing", packing.unwrap_or_else(|| "none".to_owned())));
    for (name, theirs) in FACTS {
        let value = root.attribute(theirs).and_then(|attribute| attribute.read_string());
        facts.extend(value.ok().map(|value| (name, value)));
    }
    let sensor = match (sensor(&root, &node), &node) {
        (None, Node::Group(group)) => size_beside(file, bytes, group)?,
        (sensor, _) => sensor,
    };
    let t_offset = match (at(&root, T_OFFSET)?, &node) {
        (Some(Node::Dataset(offset)), Node::Group(_)) => whole(file, bytes, &offset)?,
        _ => 0,
    };
    let header = Header { sensor, usual_sensor, facts };
    Ok(Layout { tables, columns, t_offset, unit, header, remarks })
}

/// The object at `path` below `group`, if there is one.
fn at(group: &Group, path: &str) -> Result<Option<Node>, Error> {
    let (name, rest) = match path.split_once('/') {
        None if path.is_empty() => return Ok(Some(Node::Group(group.clone()))),
        None => (path, ""),
        Some(parts) => parts,
    };
    // Names first: asking for a member that is not there is an error of the library.
    let (groups, datasets) = group.member_names()?;
    if groups.iter().any(|found| found == name) {
        return at(&group.group(name)?, rest);
    }
    if rest.is_empty() && datasets.iter().any(|found| found == name) {
        return group.dataset(name).map(|dataset| Some(Node::Dataset(Box::new(dataset))));
    }
    Ok(None)
}

/// Whether something may be events: four columns, or one array of all.
fn is_events(node: &Node, given: &ColumnNames) -> Result<bool, Error> {
    Ok(match node {
        Node::Group(group) => {
            let (_, datasets) = group.member_names()?;
            places(&datasets.iter().map(String::as_str), given).is_ok()
        }
        Node::Dataset(_) => true,
    })
}

type Columns = (Vec<Table>, [Column; 4], Option<TimeUnit>);

/// Four datasets, a column each.
fn of_group(
    file: &Hdf5File,
    bytes: &Arc<Bytes>,
    group: &Group,
    given: &ColumnNames,
) -> Result<Columns, LayoutError> {
    let (_, datasets) = group.member_names()?;
    let found = places(&datasets.iter().map(String::as_str), given);
    let Places { places, unit } =
        found.map_err(|missing| Error::DatasetNotFound(REQUIRED[missing[0]].to_owned()))?;
    let (mut tables, mut columns) = (Vec::new(), Vec::new());
    for place in places {
        let dataset = group.dataset(&datasets[place])?;
        // Some programs save a column as a matrix of one column.
        let is_column = matches!(dataset.shape(), [_] | [_, 1]);
        let number = Number::from_datatype(dataset.dtype(), 0).filter(|_| is_column);
        let number = number.ok_or_else(|| not_events(&dataset))?;
        columns.push(Column { table: tables.len(), number });
        tables.push(Table::new(file, bytes, &dataset, 0)?);
    }
    four(tables, &columns, unit)
}

/// One dataset of all columns, which have names or places.
fn of_dataset(
    file: &Hdf5File,
    bytes: &Arc<Bytes>,
    dataset: &Dataset,
    given: &ColumnNames,
) -> Result<Columns, LayoutError> {
    if let (Datatype::Compound { fields, .. }, [_]) = (dataset.dtype(), dataset.shape()) {
        let found = places(&fields.iter().map(|field| field.name.as_str()), given);
        let Places { places, unit } = found.map_err(|_| not_events(dataset))?;
        let mut columns = Vec::new();
        for place in places {
            let field = &fields[place];
            let number = Number::from_datatype(&field.datatype, field.byte_offset as usize);
            columns.push(Column { table: 0, number: number.ok_or_else(|| not_events(dataset))? });
        }
        return four(vec![Table::new(file, bytes, dataset, 0)?], &columns, unit);
    }
    // Further columns are left alone.
    let is_table = matches!(dataset.shape(), [_, columns] if *columns >= 4);
    let number = Number::from_datatype(dataset.dtype(), 0).filter(|_| is_table);
    let mut number = number.ok_or_else(|| not_events(dataset))?;
    // Columns that do not share their chunks are tables of their own.
    let width = dataset.chunks().and_then(|dims| dims.get(1).copied()).unwrap_or(u32::MAX).max(1);
    let (mut tables, mut columns) = (Vec::new(), Vec::new());
    for place in 0..4_u32 {
        if place % width == 0 {
            tables.push(Table::new(file, bytes, dataset, place.into())?);
        }
        number.offset = (place % width) as usize * number.size();
        columns.push(Column { table: tables.len() - 1, number });
    }
    // Without names the values themselves say which column is which, unless the caller does.
    let order = match given.indices().filter(|order| order.iter().all(|place| *place < 4)) {
        Some(given) => given,
        None => order(&mut tables, &columns).map_err(LayoutError::Rows)?,
    };
    four(tables, &order.map(|place| columns[place]), None)
}

fn four(
    tables: Vec<Table>,
    columns: &[Column],
    unit: Option<TimeUnit>,
) -> Result<Columns, LayoutError> {
    let missing = || Error::InvalidData("not four columns".to_owned());
    Ok((tables, columns.try_into().map_err(|_| missing())?, unit))
}

fn not_events(dataset: &Dataset) -> Error {
    let (name, shape) = (dataset.name(), dataset.shape());
    let kind = match dataset.dtype() {
        Datatype::Compound { fields, .. } => {
            let names: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
            format!("fields {}", names.join(", "))
        }
        Datatype::FixedPoint { .. } | Datatype::FloatingPoint { .. } => "plain values".to_owned(),
        _ => "values that are not numeric".to_owned(),
    };
    Error::Other(format!("{name}: {kind} in the shape {shape:?} are no events (t, x, y, p)"))
}

/// The places of t, x, y and p among columns without names, from the first rows.
fn order(tables: &mut [Table], columns: &[Column]) -> Result<[usize; 4], Damage> {
    let (mut rows, mut damage) = (LOOKED_AT, None);
    for table in tables.iter_mut() {
        if table.rows == 0 {
            return Ok(ORDERS[0].0);
        }
        let loaded = table.load_row(0)?;
        if loaded < table.rows.min(table.chunk_rows()) {
            damage = table.load_row(loaded).err();
        }
        rows = rows.min(loaded);
    }
    let values = |place: usize| {
        let Column { table, number } = columns[place];
        number.values(tables[table].rows(0, rows), tables[table].row)
    };
    let values: [Vec<f64>; 4] = std::array::from_fn(values);
    let fitting = fitting_orders(&values);
    match damage {
        // Too few rows are left for a decision.
        Some(damage) if fitting.len() > 1 => return Err(damage),
        _ => {}
    }
    fitting.last().copied().ok_or_else(|| {
        let known = ORDERS.map(|(_, name)| name).join("; ");
        let reason = format!("its columns are in none of the usual orders: {known}");
        tables[0].damage(0, &reason)
    })
}

/// A dataset of one whole number.
fn whole(file: &Hdf5File, bytes: &Arc<Bytes>, dataset: &Dataset) -> Result<i64, LayoutError> {
    let number = Number::from_datatype(dataset.dtype(), 0).ok_or_else(|| not_events(dataset))?;
    let mut table = Table::new(file, bytes, dataset, 0)?;
    table.load_row(0).map_err(LayoutError::Rows)?;
    let mut value = [0];
    if !number.whole(table.rows(0, 1), table.row, &mut value, |value| value) {
        let reason = "is no whole number of microseconds";
        return Err(LayoutError::Rows(table.damage(0, reason)));
    }
    Ok(value[0])
}

/// The size of the sensor, as RVT's preprocessing writes it: datasets beside the columns. It is a hint,
/// none where they hold anything but one value each; damage is damage.
fn size_beside(
    file: &Hdf5File,
    bytes: &Arc<Bytes>,
    group: &Group,
) -> Result<Option<SensorSize>, LayoutError> {
    let side = |name: &str| -> Result<Option<f64>, LayoutError> {
        let Some(Node::Dataset(side)) = at(group, name)? else { return Ok(None) };
        // A column of this name is no size.
        let is_one = side.num_elements()? == 1;
        let number = Number::from_datatype(side.dtype(), 0).filter(|_| is_one);
        let Some(number) = number else { return Ok(None) };
        let mut table = Table::new(file, bytes, &side, 0)?;
        table.load_row(0).map_err(LayoutError::Rows)?;
        Ok(number.values(table.rows(0, 1), table.row).first().copied())
    };
    let (width, height) = (side("width")?, side("height")?);
    Ok(width.zip(height).and_then(|(width, height)| size(width, height)))
}

/// The size of these whole numbers of pixels.
fn size(width: f64, height: f64) -> Option<SensorSize> {
    let is_size = |value: &f64| (1.0..65_536.0).contains(value) && value.fract() == 0.0;
    let is_both = is_size(&width) && is_size(&height);
    is_both.then_some(SensorSize { width: width as u16, height: height as u16 })
}

/// The size of the sensor, as one of the attributes of a file or of its events says.
fn sensor(root: &Group, events: &Node) -> Option<SensorSize> {
    let attribute = |name: &str| {
        let beside = match events {
            Node::Group(group) => group.attribute(name),
            Node::Dataset(dataset) => dataset.attribute(name),
        };
        beside.or_else(|_| root.attribute(name)).ok()
    };
    let values = |attribute: &Attribute| {
        let number = Number::from_datatype(&attribute.datatype, 0)?;
        Some(number.values(&attribute.raw_data, number.size()))
    };
    // Prophesee's: `1280x720`.
    if let Some(geometry) = attribute("geometry").and_then(|found| found.read_string().ok()) {
        let (width, height) = geometry.trim().split_once('x')?;
        return size(width.parse().ok()?, height.parse().ok()?);
    }
    // Those of E2VID and of what writes for it: rows, columns.
    if let Some(resolution) = attribute("sensor_resolution") {
        return match values(&resolution)?.as_slice() {
            [height, width, ..] => size(*width, *height),
            _ => None,
        };
    }
    let one = |name| attribute(name).and_then(|attribute| values(&attribute)?.first().copied());
    size(one("width")?, one("height")?)
}

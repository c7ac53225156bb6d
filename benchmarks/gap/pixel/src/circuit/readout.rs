//! Background, readout and clock in circuit units.

/// Events that no light causes; they leave the pixel's memory alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Background {
    /// Rate of ON events for each pixel, Hz.
    pub on_hz: f64,
    /// Rate of OFF events for each pixel, Hz.
    pub off_hz: f64,
    /// Pixels that fire by themselves.
    pub hot: Option<HotPixels>,
}

/// Pixels with a broken junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HotPixels {
    /// Expected number among the pixels of the sensor.
    pub count: f64,
    /// Median of their rates, Hz.
    pub median_hz: f64,
    /// Spread of the rates (sigma of the logarithm).
    pub spread_ln: f64,
}

/// Way from the pixels to the time-stamper.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Readout {
    /// Access scheme: the order in which pixels are read.
    pub access: Access,
    /// An effect that no catalogue has.
    pub oddity: Option<ReadoutOddity>,
}

/// Access scheme: the order in which pixels are read.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Access {
    /// Every request is read at once.
    #[default]
    Direct,
    /// Requests are acknowledged row by row.
    Arbiter {
        /// Time to select a row, ns.
        row_ns: f64,
        /// Time for each event of the selected row, ns.
        event_ns: f64,
    },
    /// Columns are visited in turn.
    Scan {
        /// Time for each column, ns.
        column_ns: f64,
    },
}

/// Faults of the readout that no catalogue knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReadoutOddity {
    /// Events come back later at the same pixel.
    Echo {
        /// Share of the events that come back.
        share: f64,
        /// Delay, s.
        delay_s: f64,
    },
    /// Events get lost in bursts (a two-state process over the whole sensor).
    BurstLoss {
        /// Share of the events lost in a bad spell.
        share: f64,
        /// Mean length of a bad spell, s.
        bad_s: f64,
        /// Mean length of a good spell, s.
        good_s: f64,
    },
    /// Events are also sent from the pixel on the right.
    NeighbourCopy {
        /// Share of the events that are copied.
        share: f64,
        /// Delay of the copy, s.
        delay_s: f64,
    },
}

/// The time-stamper.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Clock {
    /// Period of the counter, us; 1 is the unit of the stamps.
    pub period_us: f64,
    /// Jitter of the sampled request, us r.m.s.
    pub jitter_us: f64,
    /// Delay of comparator and logic, us: the median over the pixels.
    pub latency_us: f64,
    /// Log-normal spread of the delay over the pixels (sigma of the logarithm).
    pub latency_spread_ln: f64,
    /// Zero of the counter against the frames' clock, us.
    pub offset_us: f64,
}

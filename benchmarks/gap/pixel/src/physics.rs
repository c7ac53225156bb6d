//! Constants of nature and the two voltages every formula of the pixel uses (SI units, CODATA
//! 2018).

/// Charge of an electron, C.
pub const ELEMENTARY_CHARGE_C: f64 = 1.602_176_634e-19;

/// Boltzmann's constant, J/K.
pub const BOLTZMANN_J_PER_K: f64 = 1.380_649e-23;

/// Subthreshold slope factor of the transistors (gate coupling), without unit; .6 to .8 in
/// published processes.
pub const KAPPA: f64 = 0.7;

/// Temperature at which junction currents are quoted, K.
pub const REFERENCE_TEMPERATURE_K: f64 = 300.0;

/// Femto: 1 fF = 1e-15 F and 1 fA = 1e-15 A.
pub const FEMTO: f64 = 1e-15;

/// Thermal voltage `k T / q` in volts: 25.85 mV at 300 K.
pub fn thermal_voltage_v(temperature_k: f64) -> f64 {
    BOLTZMANN_J_PER_K * temperature_k / ELEMENTARY_CHARGE_C
}

/// Volts at the photoreceptor's output for one e-fold of light, `U_T / kappa`.
pub fn volts_per_efold_v(temperature_k: f64) -> f64 {
    thermal_voltage_v(temperature_k) / KAPPA
}

/// Rate `I / (C U_T)` in 1/s of a node whose conductance is that of a subthreshold transistor
/// carrying `current_a`, on `capacitance_ff`.
pub fn node_rate_per_s(current_a: f64, capacitance_ff: f64, temperature_k: f64) -> f64 {
    current_a / (capacitance_ff * FEMTO * thermal_voltage_v(temperature_k))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thermal_voltage_is_26_millivolts_at_room_temperature() {
        assert!((thermal_voltage_v(300.0) - 0.025_852).abs() < 1e-6);
    }

    #[test]
    fn ten_picoamperes_on_61_6_femtofarads_have_a_corner_of_one_kilohertz() {
        let corner_hz = node_rate_per_s(10e-12, 61.563, 300.0) / std::f64::consts::TAU;
        assert!((corner_hz - 1000.0).abs() < 1.0);
    }
}

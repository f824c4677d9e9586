//! Where the objects of a world are.

/// Their places, in single precision.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    /// In metres; shape `[n_objects]` each.
    x_m: Vec<f32>,
    y_m: Vec<f32>,
}

impl Objects {
    /// Objects at these places, in metres; shape `[n_objects][2]`.
    pub fn at(places_m: &[[f64; 2]]) -> Self {
        let along = |axis: usize| places_m.iter().map(|place_m| place_m[axis] as f32).collect();
        Self { x_m: along(0), y_m: along(1) }
    }

    /// All x and all y, in metres.
    pub fn columns(&self) -> [&[f32]; 2] {
        [&self.x_m, &self.y_m]
    }

    /// The same, to be changed.
    pub fn columns_mut(&mut self) -> [&mut [f32]; 2] {
        [&mut self.x_m, &mut self.y_m]
    }

    /// Place by place, in metres.
    pub fn places(&self) -> impl Iterator<Item = [f32; 2]> + '_ {
        self.x_m.iter().zip(&self.y_m).map(|(x_m, y_m)| [*x_m, *y_m])
    }
}

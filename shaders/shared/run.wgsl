// Where a muscle's run stands in the iterates: two halves an instance, in each one muscle after the other its box, then
// two entries a point. Reads the global params.
fn dynamics_run(instance: u32, muscle: u32, first_point: u32, half: u32) -> u32 {
    let size = 2u * (params.muscle_count + params.point_count);
    return (2u * instance + half) * size + 2u * (muscle + first_point);
}

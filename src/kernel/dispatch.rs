//! How many workgroups a number of threads needs, folded where one row is not enough.

/// Largest number of workgroups in one dimension that WebGPU promises.
pub const MAX_GROUPS: u32 = 65_535;

/// Workgroups in x and y for `items` threads in groups of `workgroup`; `None` where there is nothing to do or the
/// fold itself would not fit.
///
/// Kernels undo the fold with `dispatch_index`; up to a row of threads beyond `items` return at once.
pub fn groups(items: u64, workgroup: u32) -> Option<[u32; 2]> {
    let total = items.div_ceil(u64::from(workgroup));
    if total == 0 {
        return None;
    }
    let rows = total.div_ceil(u64::from(MAX_GROUPS));
    let columns = total.div_ceil(rows);
    let threads = rows * columns * u64::from(workgroup);
    (rows <= u64::from(MAX_GROUPS) && threads <= u64::from(u32::MAX)).then_some([columns as u32, rows as u32])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_cover_every_thread_and_little_more() {
        for items in [1u64, 63, 64, 65, 4_194_240, 4_194_241, 10_000_000, 1 << 31] {
            let [x, y] = groups(items, 64).expect("fits");
            let threads = u64::from(x) * u64::from(y) * 64;
            assert!(x <= MAX_GROUPS && threads >= items && threads - items < 64 * u64::from(y) + 64, "{items}");
        }
        assert_eq!(groups(64, 64), Some([1, 1]));
        assert_eq!(groups(65_535 * 64 + 1, 64).expect("folds")[1], 2);
    }

    #[test]
    fn nothing_and_too_much_are_refused() {
        assert_eq!(groups(0, 64), None);
        assert_eq!(groups(1 << 40, 64), None);
    }
}

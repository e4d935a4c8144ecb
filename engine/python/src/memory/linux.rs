//! Linux: the kernel's own estimate, and the limits of control groups.

use std::fs;
use std::path::{Path, PathBuf};

const GROUPS: &str = "/sys/fs/cgroup";

/// Free memory, bytes: of the machine, or of the narrowest of the control groups that this process is in.
pub(super) fn free_bytes() -> Option<u64> {
    let meminfo = fs::read_to_string("/proc/meminfo").ok()?;
    let of_machine = kibibytes(&meminfo, "MemAvailable:")?.saturating_mul(1024);
    let memberships = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let of_groups = folders(&memberships).into_iter().filter_map(|group| left_in(&group));
    Some(of_groups.fold(of_machine, u64::min))
}

/// The number of a row of /proc/meminfo.
fn kibibytes(meminfo: &str, name: &str) -> Option<u64> {
    meminfo.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

/// The folders of the control groups that limit a process of these memberships, and of the groups around them.
fn folders(memberships: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for line in memberships.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let root = match controllers {
            "" => Path::new(GROUPS).to_path_buf(),
            _ if controllers.split(',').any(|name| name == "memory") => Path::new(GROUPS).join("memory"),
            _ => continue,
        };
        let own = root.join(path.trim_start_matches('/'));
        // A container sees its own group as the root, whatever the path says.
        found.extend(own.ancestors().take_while(|folder| folder.starts_with(&root)).map(Path::to_path_buf));
    }
    found
}

/// Bytes that a control group may still take; `None` where it has no limit.
fn left_in(group: &Path) -> Option<u64> {
    let number = |name: &str| fs::read_to_string(group.join(name)).ok()?.trim().parse::<u64>().ok();
    let stat = fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    // Pages of files go when memory is short.
    let of_files = |name: &str| kibibytes(&stat, name).unwrap_or(0);
    let (most, used, idle) = match number("memory.max") {
        Some(most) => (most, number("memory.current")?, of_files("inactive_file ")),
        None => (number("memory.limit_in_bytes")?, number("memory.usage_in_bytes")?, of_files("total_inactive_file ")),
    };
    Some(most.saturating_sub(used.saturating_sub(idle)))
}

//! What large pieces of memory cost that are taken, written once and given back, as a still's buffers are: from the
//! system's allocator, and in huge pages.

#![cfg_attr(target_os = "linux", expect(unsafe_code, reason = "allocators are called directly"))]

#[cfg(target_os = "linux")]
fn main() {
    use std::alloc::{GlobalAlloc, Layout, System};
    use std::hint::black_box;

    use criterion::{Criterion, Throughput};
    use polyreel_huge_pages::HugePages;

    let mut criterion = Criterion::default().configure_from_args();
    for mebibytes in [1, 4, 12] {
        let layout = Layout::array::<u8>(mebibytes << 20).expect("a small size");
        let fill = |allocator: &dyn GlobalAlloc| {
            // SAFETY: the layout is not empty; the memory is as long as it says, and is given back once.
            unsafe {
                let memory = allocator.alloc(layout);
                assert!(!memory.is_null(), "out of memory");
                memory.write_bytes(1, layout.size());
                black_box(memory);
                allocator.dealloc(memory, layout);
            }
        };
        let mut group = criterion.benchmark_group(format!("{mebibytes} MiB"));
        group.throughput(Throughput::Bytes(layout.size() as u64));
        group.bench_function("system", |b| b.iter(|| fill(&System)));
        group.bench_function("huge pages", |b| b.iter(|| fill(&HugePages)));
        group.finish();
    }
    criterion.final_summary();
}

#[cfg(not(target_os = "linux"))]
fn main() {}

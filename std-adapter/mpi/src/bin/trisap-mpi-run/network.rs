//! What messages cost here: the constants of the model of many ranks.

use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use std::time::Instant;

const LONG: usize = 8 << 20;
/// Each number is the best of so many attempts: others use the machine too.
const ATTEMPTS: u32 = 10;

/// Prints, on the first rank, the time of a short message and of a long one from the first to the last rank, and of a reduction of
/// all ranks. All ranks have to call it.
pub(crate) fn print(comm: &SimpleCommunicator) {
    let ranks = comm.size();
    let mut seconds = [f64::INFINITY; 3];
    let mut long = vec![0_u8; LONG];
    for _ in 0..ATTEMPTS {
        if ranks > 1 {
            seconds[0] = seconds[0].min(one_way(comm, &mut [0; 8], 1000));
            seconds[1] = seconds[1].min(one_way(comm, &mut long, 10));
        }
        seconds[2] = seconds[2].min(reduction(comm, 1000));
    }
    if comm.rank() == 0 {
        if ranks > 1 {
            println!("message of 8 bytes: {:.2} microseconds", seconds[0] * 1e6);
            println!("message of {LONG} bytes: {:.2} GB/s", LONG as f64 / seconds[1] * 1e-9);
        }
        println!("reduction of {ranks} ranks: {:.2} microseconds", seconds[2] * 1e6);
    }
}

/// The seconds of a message from the first rank to the last one, as half of there and back.
fn one_way(comm: &SimpleCommunicator, bytes: &mut [u8], times: u32) -> f64 {
    let (rank, last) = (comm.rank(), comm.size() - 1);
    comm.barrier();
    let begun = Instant::now();
    for _ in 0..times {
        if rank == 0 {
            comm.process_at_rank(last).send(&*bytes);
            comm.process_at_rank(last).receive_into(bytes);
        } else if rank == last {
            comm.process_at_rank(0).receive_into(bytes);
            comm.process_at_rank(0).send(&*bytes);
        }
    }
    begun.elapsed().as_secs_f64() / f64::from(times) / 2.0
}

fn reduction(comm: &SimpleCommunicator, times: u32) -> f64 {
    let mut sums = [0_u64; 3];
    comm.barrier();
    let begun = Instant::now();
    for _ in 0..times {
        comm.all_reduce_into(&[1_u64, 2, 3], &mut sums, SystemOperation::sum());
    }
    begun.elapsed().as_secs_f64() / f64::from(times)
}

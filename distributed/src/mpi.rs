//! The functions of MPI that are used, declared by hand as those of PETSc are. `build.rs` has checked that MPI is Open MPI, whose
//! handles are pointers.

#![allow(unsafe_code)]

use std::ffi::{c_int, c_void};

use crate::error::PetscError;

/// `MPI_Comm`, `MPI_Request`, `MPI_Datatype` and `MPI_Op` of Open MPI.
pub type Handle = *mut c_void;

/// An object of Open MPI. Only its address is used.
#[repr(C)]
pub struct Predefined {
    inside: [u8; 0],
}

unsafe extern "C" {
    static ompi_mpi_comm_self: Predefined;
    static ompi_mpi_double: Predefined;
    static ompi_mpi_uint64_t: Predefined;
    static ompi_mpi_op_sum: Predefined;

    pub fn MPI_Comm_dup(communicator: Handle, copy: *mut Handle) -> c_int;
    pub fn MPI_Comm_free(communicator: *mut Handle) -> c_int;
    pub fn MPI_Iallgather(
        own: *const c_void,
        own_count: c_int,
        own_type: Handle,
        all: *mut c_void,
        count_of_each: c_int,
        type_of_each: Handle,
        communicator: Handle,
        request: *mut Handle,
    ) -> c_int;
    pub fn MPI_Allreduce(
        own: *const c_void,
        result: *mut c_void,
        count: c_int,
        kind: Handle,
        operation: Handle,
        communicator: Handle,
    ) -> c_int;
    pub fn MPI_Irecv(
        list: *mut c_void,
        count: c_int,
        kind: Handle,
        from: c_int,
        tag: c_int,
        communicator: Handle,
        request: *mut Handle,
    ) -> c_int;
    pub fn MPI_Isend(
        list: *const c_void,
        count: c_int,
        kind: Handle,
        to: c_int,
        tag: c_int,
        communicator: Handle,
        request: *mut Handle,
    ) -> c_int;
    pub fn MPI_Test(request: *mut Handle, done: *mut c_int, status: *mut c_void) -> c_int;
    pub fn MPI_Wait(request: *mut Handle, status: *mut c_void) -> c_int;
    pub fn MPI_Abort(communicator: Handle, code: c_int) -> c_int;
}

fn handle(object: *const Predefined) -> Handle {
    object.cast_mut().cast()
}

/// `MPI_COMM_SELF`.
pub fn this_process() -> Handle {
    handle(&raw const ompi_mpi_comm_self)
}

/// `MPI_DOUBLE`.
pub fn double() -> Handle {
    handle(&raw const ompi_mpi_double)
}

/// `MPI_UINT64_T`.
pub fn unsigned() -> Handle {
    handle(&raw const ompi_mpi_uint64_t)
}

/// `MPI_SUM`.
pub fn sum() -> Handle {
    handle(&raw const ompi_mpi_op_sum)
}

/// The error of a call of `function`, if its code says that there was one.
pub fn check(function: &'static str, code: c_int) -> Result<(), PetscError> {
    if code == 0 { Ok(()) } else { Err(PetscError::Mpi { function, code }) }
}

/// Calls a function of MPI by its name, and returns its error.
macro_rules! call_mpi {
    ($function:ident($($argument:expr),* $(,)?)) => {
        $crate::mpi::check(stringify!($function), $crate::mpi::$function($($argument),*))
    };
}
pub(crate) use call_mpi;

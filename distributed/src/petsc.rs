//! The functions of PETSc's C interface that are used, declared by hand: a few dozen do not ask for a generator of bindings.
//! `build.rs` has checked that the scalars, indices and communicators are of these types.

#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_double, c_int, c_void};
use std::ptr;

use crate::error::PetscError;

/// `PetscErrorCode`.
pub type Code = c_int;
/// `PetscInt`.
pub type Index = i32;
/// `MPI_Comm` of Open MPI.
pub type Communicator = *mut c_void;
/// `Vec`, `Mat`, `KSP`, `PC`, `MatNullSpace`, `MatPartitioning`, `IS` and `VecScatter`: pointers to what PETSc alone knows.
pub type Object = *mut c_void;

/// `PETSC_TRUE`.
pub const TRUE: c_int = 1;
/// `PETSC_FALSE`.
pub const FALSE: c_int = 0;
/// `INSERT_VALUES`.
pub const INSERT: c_int = 1;
/// `SCATTER_FORWARD`.
pub const FORWARD: c_int = 0;
/// `NORM_2`.
pub const EUCLIDEAN: c_int = 1;
/// `PETSC_DEFAULT`.
pub const DEFAULT: c_double = -2.0;
/// `MAT_INITIAL_MATRIX`.
pub const INITIAL: c_int = 0;
/// `MAT_NO_OFF_PROC_ENTRIES`.
pub const NO_ENTRIES_OF_OTHERS: c_int = 17;
/// `MAT_FINAL_ASSEMBLY`.
pub const FINAL: c_int = 0;
/// `PC_COMPOSITE_SCHUR`.
pub const SCHUR: c_int = 4;
/// `PC_FIELDSPLIT_SCHUR_FACT_FULL`.
pub const FULL: c_int = 3;
/// `PC_FIELDSPLIT_SCHUR_PRE_SELFP`.
pub const BY_DIAGONAL: c_int = 1;
/// `KSP_NORM_UNPRECONDITIONED`.
pub const UNPRECONDITIONED: c_int = 2;

/// `PetscErrorType` handler.
pub type Handler = unsafe extern "C" fn(
    Communicator,
    c_int,
    *const c_char,
    *const c_char,
    Code,
    c_int,
    *const c_char,
    *mut c_void,
) -> Code;

unsafe extern "C" {
    pub static PETSC_COMM_WORLD: Communicator;
    pub static PetscGlobalRank: c_int;
    pub static PetscGlobalSize: c_int;

    pub fn PetscInitializeNoArguments() -> Code;
    pub fn PetscFinalize() -> Code;
    pub fn PetscPushErrorHandler(handler: Option<Handler>, context: *mut c_void) -> Code;
    pub fn PetscReturnErrorHandler(
        communicator: Communicator,
        line: c_int,
        function: *const c_char,
        file: *const c_char,
        code: Code,
        kind: c_int,
        message: *const c_char,
        context: *mut c_void,
    ) -> Code;
    pub fn PetscErrorMessage(code: c_int, text: *mut *const c_char, specific: *mut *mut c_char) -> Code;

    pub fn VecCreateMPI(comm: Communicator, own: Index, all: Index, vector: *mut Object) -> Code;
    pub fn VecSetBlockSize(vector: Object, size: Index) -> Code;
    pub fn VecGetArray(vector: Object, values: *mut *mut c_double) -> Code;
    pub fn VecRestoreArray(vector: Object, values: *mut *mut c_double) -> Code;
    pub fn VecGetArrayRead(vector: Object, values: *mut *const c_double) -> Code;
    pub fn VecRestoreArrayRead(vector: Object, values: *mut *const c_double) -> Code;
    pub fn VecNorm(vector: Object, kind: c_int, norm: *mut c_double) -> Code;
    pub fn VecAYPX(y: Object, factor: c_double, x: Object) -> Code;
    pub fn VecDestroy(vector: *mut Object) -> Code;
    pub fn VecScatterCreateToAll(vector: Object, scatter: *mut Object, all: *mut Object) -> Code;
    pub fn VecScatterBegin(scatter: Object, from: Object, to: Object, mode: c_int, way: c_int) -> Code;
    pub fn VecScatterEnd(scatter: Object, from: Object, to: Object, mode: c_int, way: c_int) -> Code;
    pub fn VecScatterDestroy(scatter: *mut Object) -> Code;

    pub fn MatCreate(comm: Communicator, matrix: *mut Object) -> Code;
    pub fn MatSetSizes(
        matrix: Object,
        rows: Index,
        columns: Index,
        all_rows: Index,
        all_columns: Index,
    ) -> Code;
    pub fn MatSetBlockSize(matrix: Object, size: Index) -> Code;
    pub fn MatSetType(matrix: Object, name: *const c_char) -> Code;
    pub fn MatSeqAIJSetPreallocation(matrix: Object, each: Index, counts: *const Index) -> Code;
    pub fn MatMPIAIJSetPreallocation(
        matrix: Object,
        inside: Index,
        counts_inside: *const Index,
        outside: Index,
        counts_outside: *const Index,
    ) -> Code;
    pub fn MatMPIAIJGetSeqAIJ(
        matrix: Object,
        inside: *mut Object,
        outside: *mut Object,
        columns: *mut *const Index,
    ) -> Code;
    pub fn MatSeqAIJGetArray(matrix: Object, values: *mut *mut c_double) -> Code;
    pub fn MatSeqAIJRestoreArray(matrix: Object, values: *mut *mut c_double) -> Code;
    pub fn MatSetOption(matrix: Object, option: c_int, is_set: c_int) -> Code;
    pub fn MatSetValues(
        matrix: Object,
        row_count: Index,
        rows: *const Index,
        column_count: Index,
        columns: *const Index,
        values: *const c_double,
        mode: c_int,
    ) -> Code;
    pub fn MatAssemblyBegin(matrix: Object, kind: c_int) -> Code;
    pub fn MatAssemblyEnd(matrix: Object, kind: c_int) -> Code;
    pub fn MatGetDiagonal(matrix: Object, diagonal: Object) -> Code;
    pub fn MatSetNearNullSpace(matrix: Object, space: Object) -> Code;
    pub fn MatMult(matrix: Object, x: Object, product: Object) -> Code;
    pub fn MatMultTranspose(matrix: Object, x: Object, product: Object) -> Code;
    pub fn MatTranspose(matrix: Object, reuse: c_int, transposed: *mut Object) -> Code;
    pub fn MatDestroy(matrix: *mut Object) -> Code;
    pub fn MatNullSpaceCreate(
        comm: Communicator,
        constant: c_int,
        count: Index,
        vectors: *const Object,
        space: *mut Object,
    ) -> Code;
    pub fn MatNullSpaceDestroy(space: *mut Object) -> Code;

    pub fn KSPCreate(comm: Communicator, solver: *mut Object) -> Code;
    pub fn KSPSetType(solver: Object, name: *const c_char) -> Code;
    pub fn KSPGetPC(solver: Object, preconditioner: *mut Object) -> Code;
    pub fn KSPSetOptionsPrefix(solver: Object, prefix: *const c_char) -> Code;
    pub fn KSPSetFromOptions(solver: Object) -> Code;
    pub fn KSPGetTolerances(
        solver: Object,
        relative: *mut c_double,
        absolute: *mut c_double,
        divergence: *mut c_double,
        iterations: *mut Index,
    ) -> Code;
    pub fn KSPSetNormType(solver: Object, kind: c_int) -> Code;
    pub fn KSPSetOperators(solver: Object, matrix: Object, preconditioner: Object) -> Code;
    pub fn KSPSetTolerances(
        solver: Object,
        relative: c_double,
        absolute: c_double,
        divergence: c_double,
        iterations: Index,
    ) -> Code;
    pub fn KSPSetResidualHistory(solver: Object, values: *mut c_double, count: Index, reset: c_int) -> Code;
    pub fn KSPGetResidualHistory(solver: Object, values: *mut *const c_double, count: *mut Index) -> Code;
    pub fn KSPSetUp(solver: Object) -> Code;
    pub fn KSPSolve(solver: Object, b: Object, x: Object) -> Code;
    pub fn KSPSolveTranspose(solver: Object, b: Object, x: Object) -> Code;
    pub fn KSPGetConvergedReason(solver: Object, reason: *mut c_int) -> Code;
    pub fn KSPGetConvergedReasonString(solver: Object, text: *mut *const c_char) -> Code;
    pub fn KSPGetIterationNumber(solver: Object, count: *mut Index) -> Code;
    pub fn KSPDestroy(solver: *mut Object) -> Code;
    pub fn PCSetType(preconditioner: Object, name: *const c_char) -> Code;
    pub fn PCFactorGetMatrix(preconditioner: Object, factor: *mut Object) -> Code;
    pub fn MatGetInertia(
        factor: Object,
        negative: *mut Index,
        zero: *mut Index,
        positive: *mut Index,
    ) -> Code;
    pub fn PCFactorSetMatSolverType(preconditioner: Object, name: *const c_char) -> Code;
    pub fn PCFieldSplitSetIS(preconditioner: Object, name: *const c_char, rows: Object) -> Code;
    pub fn PCFieldSplitSetType(preconditioner: Object, kind: c_int) -> Code;
    pub fn PCFieldSplitSetSchurFactType(preconditioner: Object, kind: c_int) -> Code;
    pub fn PCFieldSplitSetSchurPre(preconditioner: Object, kind: c_int, matrix: Object) -> Code;

    pub fn PetscMallocA(
        count: c_int,
        clear: c_int,
        line: c_int,
        function: *const c_char,
        file: *const c_char,
        bytes: usize,
        memory: *mut *mut c_void,
        ...
    ) -> Code;
    pub fn MatCreateMPIAdj(
        comm: Communicator,
        rows: Index,
        columns: Index,
        starts: *mut Index,
        neighbours: *mut Index,
        weights: *mut Index,
        graph: *mut Object,
    ) -> Code;
    pub fn MatPartitioningCreate(comm: Communicator, partitioning: *mut Object) -> Code;
    pub fn MatPartitioningSetAdjacency(partitioning: Object, graph: Object) -> Code;
    pub fn MatPartitioningSetType(partitioning: Object, name: *const c_char) -> Code;
    pub fn MatPartitioningSetVertexWeights(partitioning: Object, weights: *const Index) -> Code;
    pub fn MatPartitioningSetNParts(partitioning: Object, count: Index) -> Code;
    pub fn MatPartitioningSetFromOptions(partitioning: Object) -> Code;
    pub fn MatPartitioningApply(partitioning: Object, parts: *mut Object) -> Code;
    pub fn MatPartitioningDestroy(partitioning: *mut Object) -> Code;

    pub fn ISGetIndices(rows: Object, list: *mut *const Index) -> Code;
    pub fn ISRestoreIndices(rows: Object, list: *mut *const Index) -> Code;
    pub fn ISCreateStride(
        comm: Communicator,
        count: Index,
        first: Index,
        step: Index,
        rows: *mut Object,
    ) -> Code;
    pub fn ISSetBlockSize(rows: Object, size: Index) -> Code;
    pub fn ISDestroy(rows: *mut Object) -> Code;
    pub fn PetscObjectCompose(object: Object, name: *const c_char, other: Object) -> Code;
    pub fn PetscOptionsHasName(
        options: Object,
        prefix: *const c_char,
        name: *const c_char,
        is_set: *mut c_int,
    ) -> Code;
    pub fn PetscOptionsSetValue(options: Object, name: *const c_char, value: *const c_char) -> Code;
}

/// The error of a call of `function`, if its code says that there was one.
pub fn check(function: &'static str, code: Code) -> Result<(), PetscError> {
    if code == 0 {
        return Ok(());
    }
    let (mut text, mut specific) = (ptr::null(), ptr::null_mut());
    // SAFETY: both pointers are written to, with strings that PETSc owns and keeps until the next error.
    let found = unsafe { PetscErrorMessage(code, &mut text, &mut specific) };
    let told = if found == 0 { [text, specific.cast_const()] } else { [ptr::null(); 2] };
    // SAFETY: as above; null where there is nothing to say.
    let told = told.map(|text| if text.is_null() { None } else { Some(unsafe { CStr::from_ptr(text) }) });
    let told: Vec<_> = told.iter().flatten().map(|text| text.to_string_lossy().trim().to_owned()).collect();
    Err(PetscError::Call { function, code, message: told.join(": ") })
}

/// Calls a function of PETSc by its name, and returns its error.
macro_rules! call {
    ($function:ident($($argument:expr),* $(,)?)) => {
        $crate::petsc::check(stringify!($function), $crate::petsc::$function($($argument),*))
    };
}
pub(crate) use call;

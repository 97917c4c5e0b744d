/* Compiled problems as functions of plain arrays: a map F from controls m to outputs, with products of its Jacobian and vectors.
 *
 * FORMS_PROBLEM(level) declares the functions level_open, level_value, ... of a problem that Rust exports as
 * `forms_bindings::export_c!(level, constructor)`. All numbers are doubles, all arrays contiguous; lengths are checked.
 *
 * Functions that return an int return 0 if all went well; otherwise they have written nothing, and level_last_error() says why. Calls of
 * one problem may come from any thread, and wait for one another; level_close has to be the last.
 */
#ifndef FORMS_H
#define FORMS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A problem, which lives in a thread of its own. */
typedef struct forms_problem forms_problem;

#define FORMS_PROBLEM(NAME)                                                                                            \
    /* Makes a problem of `count` named numbers; what is not named has its default. */                                 \
    int NAME##_open(const char *const *names, const double *values, size_t count, forms_problem **problem);            \
    /* Ends it. A null pointer is nothing to end. */                                                                   \
    void NAME##_close(forms_problem *problem);                                                                         \
    /* What the last failure of a call from this thread said, until the next failure in the thread. */                 \
    const char *NAME##_last_error(void);                                                                               \
    /* The number of controls by name, and of their values: the length of m. */                                        \
    int NAME##_inputs(const forms_problem *problem, size_t *parts, size_t *values);                                    \
    /* The number of outputs by name, and of their values: the length of F(m). */                                      \
    int NAME##_outputs(const forms_problem *problem, size_t *parts, size_t *values);                                   \
    /* Name, which lives as long as the problem, and number of values of a control, in the order of m. */              \
    int NAME##_input(const forms_problem *problem, size_t index, const char **name, size_t *values);                   \
    /* The same of an output. */                                                                                       \
    int NAME##_output(const forms_problem *problem, size_t index, const char **name, size_t *values);                  \
    /* The controls to begin with. */                                                                                  \
    int NAME##_start(const forms_problem *problem, double *m, size_t length);                                          \
    /* F(m). */                                                                                                        \
    int NAME##_value(const forms_problem *problem, const double *m, size_t m_length, double *value,                    \
                     size_t value_length);                                                                             \
    /* The transposed Jacobian at m times a cotangent, a number per output: one adjoint. */                            \
    int NAME##_vjp(const forms_problem *problem, const double *m, size_t m_length, const double *cotangent,            \
                   size_t cotangent_length, double *product, size_t product_length);                                   \
    /* The Jacobian at m times a direction of the controls: an adjoint per output. */                                  \
    int NAME##_jvp(const forms_problem *problem, const double *m, size_t m_length, const double *direction,            \
                   size_t direction_length, double *product, size_t product_length);

#ifdef __cplusplus
}
#endif

#endif

/* Calls the problems `level` and `deflection` through their C interface, and prints what they give, a number or a message per line. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "forms.h"

FORMS_PROBLEM(level)
FORMS_PROBLEM(deflection)

static void need(int status, const char *said) {
    if (status != 0) {
        fprintf(stderr, "%s\n", said);
        exit(1);
    }
}

static double *room(size_t count) {
    double *values = calloc(count, sizeof *values);
    if (values == NULL) {
        exit(1);
    }
    return values;
}

static void print(const char *name, const double *values, size_t count) {
    for (size_t k = 0; k < count; k++) {
        printf("%s %.17g\n", name, values[k]);
    }
}

int main(void) {
    const char *names[] = {"cells", "load"};
    const double numbers[] = {8, 2e-3};
    forms_problem *beam = NULL;
    need(level_open(names, numbers, 2, &beam), level_last_error());

    size_t parts, inputs, outputs, length;
    const char *name;
    need(level_inputs(beam, &parts, &inputs), level_last_error());
    need(level_outputs(beam, &parts, &outputs), level_last_error());
    need(level_input(beam, 0, &name, &length), level_last_error());
    printf("control %s %zu\n", name, length);
    double *m = room(inputs), *slope = room(inputs), *direction = room(inputs);
    need(level_start(beam, m, inputs), level_last_error());
    for (size_t k = 0; k < inputs; k++) {
        m[k] += 1e-3 * (double)k;
        direction[k] = 1.0 + (double)k;
    }
    double value, along;
    const double one = 1;
    need(level_value(beam, m, inputs, &value, 1), level_last_error());
    need(level_vjp(beam, m, inputs, &one, 1, slope, inputs), level_last_error());
    need(level_jvp(beam, m, inputs, direction, inputs, &along, 1), level_last_error());
    print("value", &value, 1);
    print("slope", slope, inputs);
    print("along", &along, 1);

    /* What does not fit is said, and nothing is written. */
    double kept = 7;
    if (level_value(beam, m, inputs - 1, &kept, 1) == 0 || kept != 7) {
        return 2;
    }
    printf("error %s\n", level_last_error());
    m[2] = NAN;
    if (level_value(beam, m, inputs, &kept, 1) == 0 || kept != 7) {
        return 2;
    }
    printf("error %s\n", level_last_error());
    m[2] = 0.02;
    if (level_value(NULL, m, inputs, &kept, 1) == 0 || level_value(beam, m, inputs, &kept, 2) == 0) {
        return 2;
    }
    printf("error %s\n", level_last_error());
    const char *unknown[] = {"cels"};
    forms_problem *none = NULL;
    if (level_open(unknown, numbers, 1, &none) == 0 || none != NULL) {
        return 2;
    }
    printf("error %s\n", level_last_error());
    if (level_input(beam, 1, &name, &length) == 0) {
        return 2;
    }
    printf("error %s\n", level_last_error());
    level_close(beam);
    level_close(NULL);

    need(deflection_open(names, numbers, 1, &beam), deflection_last_error());
    need(deflection_inputs(beam, &parts, &inputs), deflection_last_error());
    need(deflection_outputs(beam, &parts, &outputs), deflection_last_error());
    double *start = room(inputs), *found = room(outputs), *product = room(inputs);
    need(deflection_start(beam, start, inputs), deflection_last_error());
    need(deflection_value(beam, start, inputs, found, outputs), deflection_last_error());
    need(deflection_vjp(beam, start, inputs, found, outputs, product, inputs), deflection_last_error());
    print("displacement", found, outputs);
    print("product", product, inputs);
    deflection_close(beam);
    free(m), free(slope), free(direction), free(start), free(found), free(product);
    return 0;
}

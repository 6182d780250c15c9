// SPDX-License-Identifier: GPL-3.0-or-later
#include "ufcx.h"
#include "viscoelasticity_triangle_1.h"
#include <stdio.h>

/* Prints the first entry of the form a on the reference triangle, E = 1, nu = 0. */
int main(void) {
  const double constants[] = {1.0, 0.0};
  const double x[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  double A[36] = {0};
#if UFCX_VERSION_MINOR >= 10
  form_viscoelasticity_triangle_1_a->form_integrals[0]->tabulate_tensor_float64(A, NULL, constants, x, NULL,
                                                                                NULL, NULL);
#else
  form_viscoelasticity_triangle_1_a->form_integrals[0]->tabulate_tensor_float64(A, NULL, constants, x, NULL,
                                                                                NULL);
#endif
  printf("%.17g\n", A[0]);
  return 0;
}

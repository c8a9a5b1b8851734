/* Float against double, at random inputs. */
#ifndef RK_TESTS_NUMBERS_H
#define RK_TESTS_NUMBERS_H

/* Prints a line for each function: name, number of inputs, then the largest and the root mean
 * square error of the kit's, and of the plain formula in float; relative to the formula's value in
 * double. */
void numbers_print(void);

#endif

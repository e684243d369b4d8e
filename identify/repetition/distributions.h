// Student's t and chi-square of whole degrees of freedom, from one on, in closed form (Abramowitz and Stegun 1964,
// 26.7.3, 26.7.4, 26.4.4 and 26.4.5). `Student95` (identify/uncertainty/correlated_scores.h) is for fractional ones
// from two on.
#ifndef CLOTHID_IDENTIFY_REPETITION_DISTRIBUTIONS_H_
#define CLOTHID_IDENTIFY_REPETITION_DISTRIBUTIONS_H_

namespace clothid {

// P(|t| > |value|). degrees_of_freedom >= 1.
double StudentTwoSided(double value, int degrees_of_freedom);

// The half-width of a central 95 % interval of t: 12.706 for one degree of freedom, 1.96 for many.
double StudentHalfWidth95(int degrees_of_freedom);

// P(chi-square > value), value >= 0, degrees_of_freedom >= 1.
double ChiSquareAbove(double value, int degrees_of_freedom);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPETITION_DISTRIBUTIONS_H_

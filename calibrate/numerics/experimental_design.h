// Experimental designs: points distributed over the unit cube.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <random>
#include <vector>

namespace firn {

// Latin hypercube of `count` points, the best of many drawn by the smallest distance between any
// two points, those in `taken` included. Deterministic in the seed. Levels run from close to one
// face of the cube to close to the other, so that fits need not extrapolate far.
std::vector<Eigen::VectorXd> maximin_latin_hypercube(int count, int dimensions, std::uint64_t seed,
                                                     const std::vector<Eigen::VectorXd>& taken);

// Point i of a low-discrepancy sequence in the unit cube (multiples of the inverse powers of the
// generalized golden ratio; Roberts 2018).
Eigen::VectorXd quasi_random_point(std::uint64_t i, int dimensions);

// `count` points [count, dimensions] of the Halton sequence whose digits are permuted at random,
// each place of each dimension by its own permutation: every point is uniform in the cube, and the
// scatter between independent draws is the error of a mean over the points (Owen 2017,
// arXiv:1706.02808).
Eigen::MatrixXd randomized_halton(int count, int dimensions, std::mt19937_64& random);

}  // namespace firn

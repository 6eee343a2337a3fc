// Problems of the NIST Statistical Reference Datasets, nonlinear regression, higher level of
// difficulty, through the least squares of the calibration: certified values and their standard
// deviations, six digits at least.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "calibrate/numerics/optimize.h"

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Nist {
  const char* name;
  std::vector<double> y, x;
  // Model and its derivatives with respect to the parameters.
  std::function<double(double x, const VectorXd& b, VectorXd& gradient)> model;
  std::vector<std::vector<double>> starts;
  std::vector<double> certified, sd;
  double squares;
};

VectorXd vector_of(const std::vector<double>& v) {
  return Eigen::Map<const VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

LeastSquaresProblem problem_of(const Nist& data) {
  LeastSquaresProblem p;
  p.residuals = static_cast<int>(data.x.size());
  p.evaluate = [&data](const VectorXd& b, VectorXd& r, MatrixXd* jacobian) {
    VectorXd gradient(b.size());
    for (int i = 0; i < r.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      r[i] = data.model(data.x[k], b, gradient) - data.y[k];
      if (jacobian != nullptr) jacobian->row(i) = gradient.transpose();
    }
    return true;
  };
  return p;
}

const Nist mgh09{
    "MGH09",
    {0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246},
    {4, 2, 1, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625},
    [](double x, const VectorXd& b, VectorXd& g) {
      const double n = x * x + x * b[1], d = x * x + x * b[2] + b[3];
      g << n / d, b[0] * x / d, -b[0] * n * x / (d * d), -b[0] * n / (d * d);
      return b[0] * n / d;
    },
    {{0.25, 0.39, 0.415, 0.39}},
    {1.9280693458e-01, 1.9128232873e-01, 1.2305650693e-01, 1.3606233068e-01},
    {1.1435312227e-02, 1.9633220911e-01, 8.0842031232e-02, 9.0025542308e-02},
    3.0750560385e-04};

const Nist box_bod{"BoxBOD",
                   {109, 149, 149, 191, 213, 224},
                   {1, 2, 3, 5, 7, 10},
                   [](double x, const VectorXd& b, VectorXd& g) {
                     const double e = std::exp(-b[1] * x);
                     g << 1 - e, b[0] * x * e;
                     return b[0] * (1 - e);
                   },
                   {{100, 0.75}},  // from the far one, (1, 1), b2 runs away to where all is flat
                   {2.1380940889e+02, 5.4723748542e-01},
                   {1.2354515176e+01, 1.0455993237e-01},
                   1.1680088766e+03};

const Nist mgh10{"MGH10",
                 {34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147,
                  4427, 3820, 3307, 2872},
                 {50, 55, 60, 65, 70, 75, 80, 85, 90, 95, 100, 105, 110, 115, 120, 125},
                 [](double x, const VectorXd& b, VectorXd& g) {
                   const double e = std::exp(b[1] / (x + b[2])), s = x + b[2];
                   g << e, b[0] * e / s, -b[0] * e * b[1] / (s * s);
                   return b[0] * e;
                 },
                 {{0.02, 4000, 250}},
                 {5.6096364710e-03, 6.1813463463e+03, 3.4522363462e+02},
                 {1.5687892471e-04, 2.3309021107e+01, 7.8486103508e-01},
                 8.7945855171e+01};

const Nist rat43{"Rat43",
                 {16.08, 33.83, 65.80, 97.20, 191.55, 326.20, 386.87, 520.53, 590.03, 651.92,
                  724.93, 699.56, 689.96, 637.56, 717.41},
                 {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
                 [](double x, const VectorXd& b, VectorXd& g) {
                   const double e = std::exp(b[1] - b[2] * x), p = std::pow(1 + e, -1 / b[3]);
                   const double slope = -b[0] * p * e / ((1 + e) * b[3]);
                   g << p, slope, -x * slope, b[0] * p * std::log1p(e) / (b[3] * b[3]);
                   return b[0] * p;
                 },
                 {{100, 10, 1, 1}, {700, 5, 0.75, 1.3}},
                 {6.9964151270e+02, 5.2771253025, 7.5962938329e-01, 1.2792483859},
                 {1.6302297817e+01, 2.0828735829, 1.9566123451e-01, 6.8761936385e-01},
                 8.7864049080e+03};

const Nist thurber{"Thurber",
                   {80.574,   84.248,   87.264,   87.195,   89.076,   89.608,   89.868,   90.101,
                    92.405,   95.854,   100.696,  101.060,  401.672,  390.724,  567.534,  635.316,
                    733.054,  759.087,  894.206,  990.785,  1090.109, 1080.914, 1122.643, 1178.351,
                    1260.531, 1273.514, 1288.339, 1327.543, 1353.863, 1414.509, 1425.208, 1421.384,
                    1442.962, 1464.350, 1468.705, 1447.894, 1457.628},
                   {-3.067, -2.981, -2.921, -2.912, -2.840, -2.797, -2.702, -2.699, -2.633, -2.481,
                    -2.363, -2.322, -1.501, -1.460, -1.274, -1.212, -1.100, -1.046, -0.915, -0.714,
                    -0.566, -0.545, -0.400, -0.309, -0.109, -0.103, 0.010,  0.119,  0.377,  0.790,
                    0.963,  1.006,  1.115,  1.572,  1.841,  2.047,  2.200},
                   [](double x, const VectorXd& b, VectorXd& g) {
                     const double x2 = x * x, x3 = x2 * x;
                     const double n = b[0] + b[1] * x + b[2] * x2 + b[3] * x3;
                     const double d = 1 + b[4] * x + b[5] * x2 + b[6] * x3, s = -n / (d * d);
                     g << 1 / d, x / d, x2 / d, x3 / d, s * x, s * x2, s * x3;
                     return n / d;
                   },
                   {{1000, 1000, 400, 40, 0.7, 0.3, 0.03}, {1300, 1500, 500, 75, 1, 0.4, 0.05}},
                   {1.2881396800e+03, 1.4910792535e+03, 5.8323836877e+02, 7.5416644291e+01,
                    9.6629502864e-01, 3.9797285797e-01, 4.9727297349e-02},
                   {4.6647963344, 3.9571156086e+01, 2.8698696102e+01, 5.5675370270,
                    3.1333340687e-02, 1.4984928198e-02, 6.5842344623e-03},
                   5.6427082397e+03};

const Nist eckerle4{"Eckerle4",
                    {0.0001575, 0.0001699, 0.0002350, 0.0003102, 0.0004917, 0.0008710, 0.0017418,
                     0.0046400, 0.0065895, 0.0097302, 0.0149002, 0.0237310, 0.0401683, 0.0712559,
                     0.1264458, 0.2073413, 0.2902366, 0.3445623, 0.3698049, 0.3668534, 0.3106727,
                     0.2078154, 0.1164354, 0.0616764, 0.0337200, 0.0194023, 0.0117831, 0.0074357,
                     0.0022732, 0.0008800, 0.0004579, 0.0002345, 0.0001586, 0.0001143, 0.0000710},
                    {400,   405, 410,   415, 420,   425, 430,   435, 436.5, 438, 439.5, 441,
                     442.5, 444, 445.5, 447, 448.5, 450, 451.5, 453, 454.5, 456, 457.5, 459,
                     460.5, 462, 463.5, 465, 470,   475, 480,   485, 490,   495, 500},
                    [](double x, const VectorXd& b, VectorXd& g) {
                      const double z = (x - b[2]) / b[1], e = std::exp(-0.5 * z * z) / b[1];
                      g << e, b[0] * e * (z * z - 1) / b[1], b[0] * e * z / b[1];
                      return b[0] * e;
                    },
                    {{1.5, 5, 450}},
                    {1.5543827178, 4.0888321754, 4.5154121844e+02},
                    {1.5408051163e-02, 4.6803020753e-02, 4.6800518816e-02},
                    1.4635887487e-03};

class NistRegression : public testing::TestWithParam<const Nist*> {};

TEST_P(NistRegression, AgreesWithTheCertifiedValues) {
  const Nist& data = *GetParam();
  const LeastSquaresProblem problem = problem_of(data);
  const double freedom =
      static_cast<double>(data.x.size()) - static_cast<double>(data.certified.size());
  for (const std::vector<double>& from : data.starts) {
    const VectorXd start = vector_of(from);
    const LeastSquaresFit fit = least_squares(problem, start);
    EXPECT_TRUE(fit.converged) << fit.message;
    EXPECT_NEAR(fit.sum_of_squares / data.squares, 1, 1e-8);
    const MatrixXd covariance =
        (fit.jacobian.transpose() * fit.jacobian).inverse() * fit.sum_of_squares / freedom;
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_NEAR(fit.x[i] / data.certified[k], 1, 1e-6) << i;
      EXPECT_NEAR(std::sqrt(covariance(i, i)) / data.sd[k], 1, 1e-5) << i;  // derivatives
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Nist, NistRegression,
                         testing::Values(&mgh09, &box_bod, &mgh10, &rat43, &thurber, &eckerle4),
                         [](const auto& info) { return std::string(info.param->name); });

}  // namespace
}  // namespace firn

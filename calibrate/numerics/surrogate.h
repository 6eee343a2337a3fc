// A smooth model of one response over the unit cube of the parameters, fitted to a few noisy
// simulations. Predictions have a variance.
//
//   T(y)(u) = trend(u) + gp_residual(u) + noise
//
// The trend is a linear or quadratic polynomial with a Gaussian prior on its coefficients (wide for
// the linear part, a ridge for the quadratic part, so that eight points can carry it). The
// residual is either independent at every point (plain regression with lack of fit) or a Gaussian
// process with a Matern 5/2 kernel and one length for each parameter. The noise is that between
// seeds, with an uncertainty by its degrees of freedom. T is the identity or the logarithm. A few
// points hardly determine the variance and the lengths of the residual: the model is a mixture of
// members of equal weight, drawn from the posterior of these hyperparameters, because the most
// likely set alone understates the uncertainty. Equations: Rasmussen and Williams, Gaussian
// Processes for Machine Learning, sections 2.2, 2.7, 5.2 and 5.4.2.
//
// Some of the data may be of a cheaper form of the simulator (low fidelity). At those points a
// bias is added to T(y): a quadratic polynomial with a Gaussian prior, which the points in both
// forms determine (Kennedy and O'Hagan 2000, with a factor of one). Predictions are of the high
// fidelity.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace firn {

struct SurrogateData {
  Eigen::MatrixXd u;               // [points, parameters], unit cube
  Eigen::VectorXd y;               // [points], mean over the seeds
  Eigen::VectorXd noise_variance;  // [points], of that mean
  // Degrees of freedom of the estimated noise; 0: the noise is known.
  int noise_freedom = 0;
  // [points], which of them are of low fidelity; empty: none.
  std::vector<bool> low_fidelity = {};
};

// Response of the low fidelity minus that of the high one, with its standard deviation.
struct FidelityBias {
  double value = 0, sd = 0;
};

struct SurrogateForm {
  bool quadratic = false;        // trend
  bool matern = false;           // residual: a Gaussian process, else independent
  bool logarithm = false;        // of the response
  std::string describe() const;  // "quadratic in the logarithm, with lack of fit"
  bool operator==(const SurrogateForm&) const = default;
};

struct Prediction {
  double mean = 0;      // in the response's unit (the median, for a logarithm)
  double variance = 0;  // of the mean response; the seed noise of one run not included
  // The part of it that more seeds at the same points would remove; zero unless requested.
  double noise_variance = 0;
  Eigen::VectorXd mean_gradient;  // over the unit cube; empty unless requested
  Eigen::VectorXd variance_gradient;
};

class Surrogate {
 public:
  // Draws the hyperparameters of this form from their posterior. y must be positive for a
  // logarithm. At least two points. Deterministic.
  Surrogate(const SurrogateData& data, const SurrogateForm& form);

  Prediction predict(const Eigen::VectorXd& u) const { return predict(u, Parts{}); }
  // With gradients and the noise's part of the variance.
  Prediction predict_with_gradients(const Eigen::VectorXd& u) const {
    return predict(u, Parts{.gradients = true, .noise = true});
  }
  Prediction predict_with_noise(const Eigen::VectorXd& u) const {
    return predict(u, Parts{.noise = true});
  }
  // The mean of predict(), at a fraction of its time.
  double predict_mean(const Eigen::VectorXd& u) const;
  Prediction predict_low_fidelity(const Eigen::VectorXd& u) const;
  // Zero without data of low fidelity.
  FidelityBias fidelity_bias(const Eigen::VectorXd& u) const;
  // Leave-one-out errors: value of each point minus its prediction by the others [points]; unit of
  // the response, to first order for a logarithm.
  Eigen::VectorXd leave_one_out_errors() const;
  // Leave-one-out errors over their standard deviations, [points], and the sum of the logarithms of
  // the predictive densities (response's own unit, so that forms can be compared).
  Eigen::VectorXd leave_one_out_z() const;
  double leave_one_out_score() const;

  const SurrogateForm& form() const { return form_; }
  // Of the most likely hyperparameters.
  double gp_residual_sd() const;           // of the transformed response
  const Eigen::VectorXd& lengths() const;  // Matern only, unit cube

  // This model with the same hyperparameters after one more point at its predicted value (kriging
  // believer). Used to estimate the information of a run there.
  Surrogate with_fantasy_point(const Eigen::VectorXd& u, double noise_variance,
                               bool low_fidelity = false) const;

  // This model mixed with another one. Their disagreement adds to the variance.
  Surrogate mixed_with(const Surrogate& other, double share) const;

 private:
  // One set of hyperparameters, and quantities computed from it and the data.
  struct Member {
    double gp_residual_variance = 0;  // standardized
    double noise_factor = 1;          // true variance of the noise over the stated one
    Eigen::VectorXd lengths;
    std::optional<Eigen::LDLT<Eigen::MatrixXd>> covariance;  // [points, points], once factorized
    Eigen::VectorXd precision;                               // diagonal of its inverse
    Eigen::VectorXd weights;                                 // its inverse times z
    // Of independent residuals: posterior of the trend's coefficients, and the part of its
    // covariance that the noise makes.
    Eigen::VectorXd coefficients;
    Eigen::MatrixXd coefficient_covariance, noise_covariance;
  };
  // What a prediction has besides mean and variance. Each costs another solution.
  struct Parts {
    bool gradients = false, noise = false;
  };
  // What the members share in a prediction at u. For a polynomial, basis and basis_gradient alone.
  struct Place {
    Eigen::VectorXd basis;             // at u
    Eigen::MatrixXd basis_gradient;    // [basis, parameters]; empty unless gradients are requested
    Eigen::VectorXd prior_basis;       // basis times the prior variances
    double prior_variance = 0;         // of the trend at u
    Eigen::VectorXd trend_covariance;  // [points], of the trend at u with that at the data
    Eigen::MatrixXd trend_covariance_gradient;  // [points, parameters]; as basis_gradient
    Eigen::MatrixXd apart;                      // [points, parameters], u minus each point
  };
  // Vectors [points] that the predictions of the members use one after another.
  struct Scratch {
    Eigen::ArrayXd distances;
    Eigen::VectorXd covariance, half, solution;
  };
  // Prediction of one member; standardized.
  struct MemberPrediction {
    double mean = 0, variance = 0, noise = 0;
    Eigen::VectorXd mean_gradient, variance_gradient;
  };
  // Leave-one-out prediction of a point; standardized.
  struct LeftOut {
    double error = 0, variance = 0, log_density = 0;
  };
  Prediction predict(const Eigen::VectorXd& u, Parts parts) const;
  Prediction predict_alone(const Eigen::VectorXd& u, Parts parts, bool low_fidelity) const;
  Place place(const Eigen::VectorXd& u, bool gradients, bool low_fidelity) const;
  MemberPrediction predict_polynomial(const Member& member, const Place& place, Parts parts) const;
  MemberPrediction predict_process(const Member& member, const Place& place, Parts parts,
                                   Scratch& scratch) const;
  // Covariance of the response at u with that at the data, by a process; sets distances, too.
  void covariance_with_data(const Member& member, const Place& place, Scratch& scratch) const;
  // Of a sum of coefficients, by its factors h: its mean and variance, standardized.
  MemberPrediction predict_coefficients(const Member& member, const Eigen::VectorXd& h) const;
  void fit();
  void factorize(Member& member) const;
  Eigen::LDLT<Eigen::MatrixXd> covariance(const Member& member) const;
  Member member(const Eigen::VectorXd& log_parameters) const;
  double objective(const Eigen::VectorXd& log_parameters) const;
  // Trend, then bias where data of low fidelity have one.
  Eigen::VectorXd basis(const Eigen::VectorXd& u, bool low_fidelity = false) const;
  Eigen::MatrixXd basis_gradient(const Eigen::VectorXd& u) const;  // [basis, parameters]
  LeftOut left_out(Eigen::Index point) const;
  bool is_low_fidelity(Eigen::Index point) const {
    return !data_.low_fidelity.empty() && data_.low_fidelity[static_cast<std::size_t>(point)];
  }
  double transform(double y) const;
  double untransform(double t) const;

  SurrogateData data_;
  SurrogateForm form_;
  double shift_ = 0, scale_ = 1;                // z = (T(y) - shift) / scale
  Eigen::VectorXd z_, z_noise_;                 // standardized data and noise variance
  Eigen::MatrixXd h_;                           // [points, basis]
  Eigen::VectorXd prior_variance_;              // prior variance of each coefficient
  Eigen::MatrixXd trend_covariance_;            // [points, points], by that prior
  Member most_likely_;                          // not factorized
  std::vector<Member> members_;                 // of equal weight
  std::shared_ptr<const Surrogate> companion_;  // of the mixture; null: none
  double companion_share_ = 0;
  double inflation_ = 1;  // of the predicted variance: mean square of the leave-one-out errors
};

// The form among those that the number of points allows with the best leave-one-out score; the
// simpler one wins a near tie. `other` is the best of the other kind of residual or trend, for a
// cross-check; `best` predicts with a share of it that follows from the scores.
struct SurrogateChoice {
  Surrogate best;
  Surrogate other;
};
SurrogateChoice choose_surrogate(const SurrogateData& data);

}  // namespace firn

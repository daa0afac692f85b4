#include "core/optics/phase_response.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/decompositions.hpp"
#include "core/base/number_text.hpp"

namespace ovws {
namespace {

constexpr double kMaxMisfit = 0.05;  // RMS distance from the circle, in its radii
constexpr double kMaxStepRad = kTwoPi / 24.0;
constexpr double kMaxNoiseRad = 0.1;  // phase noise of one grey level
constexpr double kMinNoiseRad = 1e-3;
constexpr double kMaxDriftRad = 0.01;  // drift of the mean of a grey level's two readings
constexpr double kDriftSigmas = 3.0;   // drift below this is noise: standard deviations
constexpr double kMinLagRatio = 0.7;   // |mean| / RMS of the differences; noise averages to 0
constexpr double kMinDepthRad = 1.0;   // a shorter arc of beats does not determine a circle
constexpr double kFallSigmas = 5.0;    // a fall of the phase beyond this is not noise
constexpr double kMinBlaze = 0.05;     // relative difference; a phase range of 1 rad gives 0.15
constexpr double kBlazeNoises = 3.0;   // multiples of the repeated readings' difference
constexpr double kMaxStiffness = 1e9, kMinStiffness = 1.0;

struct Circle {
  std::complex<double> middle;
  double radius = 0.0;
  double misfit = 0.0;  ///< RMS distance of the points from the circle, in its radii
};

std::complex<double> mean_of(const GreyBeat& beat) {
  return 0.5 * (beat.first + beat.second);
}

/// Circle fit: Kasa's algebraic fit, then Gauss-Newton on the geometric distances.
Circle fit_circle(std::span<const GreyBeat> beats) {
  const auto n = Eigen::Index(beats.size());
  Eigen::MatrixXd rows(n, 3);
  Eigen::VectorXd rhs(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto z = mean_of(beats[std::size_t(k)]);
    rows.row(k) << 2.0 * z.real(), 2.0 * z.imag(), 1.0;
    rhs[k] = std::norm(z);
  }
  Eigen::Vector3d at = least_squares(rows, rhs);
  at[2] = std::sqrt(std::max(0.0, at[2] + at[0] * at[0] + at[1] * at[1]));
  for (int step = 0; step < 20; ++step) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto z = mean_of(beats[std::size_t(k)]) - std::complex<double>(at[0], at[1]);
      const double r = std::max(std::abs(z), 1e-300);
      rows.row(k) << -z.real() / r, -z.imag() / r, -1.0;
      rhs[k] = r - at[2];
    }
    const Eigen::Vector3d move = least_squares(rows, rhs);
    at -= move;
    if (move.norm() < 1e-12 * at.norm()) break;
  }
  return {{at[0], at[1]}, at[2], std::sqrt(rhs.squaredNorm() / double(n)) / at[2]};
}

Result<Circle> checked_circle(std::span<const GreyBeat> beats) {
  const Circle circle = fit_circle(beats);
  if (circle.misfit < kMaxMisfit) return circle;
  return fail(
      Errc::refused, "",
      "the fringes' complex amplitudes do not lie on a circle: check that the illumination is "
      "constant and bright enough, that nothing moves on the bench, and that slm.settle_ms is "
      "long enough (slm.settle measures it)");
}

/// Phase step from the measured level k - 1 to level k, in -pi .. pi.
double turn_rad(std::span<const GreyBeat> beats, const Circle& circle, std::size_t k) {
  return std::arg((mean_of(beats[k]) - circle.middle) *
                  std::conj(mean_of(beats[k - 1]) - circle.middle));
}

std::vector<double> unwrapped(std::span<const GreyBeat> beats, const Circle& circle) {
  std::vector<double> phases{0.0};
  for (std::size_t k = 1; k < beats.size(); ++k) {
    phases.push_back(phases.back() + turn_rad(beats, circle, k));
  }
  const double sign = phases.back() < 0.0 ? -1.0 : 1.0;
  for (double& phase : phases) phase *= sign;
  return phases;
}

/// Phase noise of the mean of a level's two readings, rad: half their difference, RMS per
/// component, but at least the circle's misfit and kMinNoiseRad.
double noise_of(std::span<const GreyBeat> beats, const Circle& circle) {
  double sum = 0.0;
  for (const GreyBeat& beat : beats) sum += std::norm(beat.first - beat.second);
  const double readings = std::sqrt(sum / (8.0 * double(beats.size()))) / circle.radius;
  return std::max({readings, circle.misfit, kMinNoiseRad});
}

/// Drift between a level's two readings beyond noise, rad, as shift of their mean. Uses the idea of
/// von Neumann's ratio test: noise of neighbouring levels is independent, but drift shifts
/// neighbouring levels equally.
double drift_of(std::span<const GreyBeat> beats, const Circle& circle) {
  double squares = 0.0, steps = 0.0;
  std::complex<double> before;
  for (std::size_t k = 0; k < beats.size(); ++k) {
    const auto moved = beats[k].second - beats[k].first;
    squares += std::norm(moved);
    if (k > 0) steps += std::norm(moved - before);
    before = moved;
  }
  const auto n = double(beats.size());
  const double noise = (1.0 + kDriftSigmas / std::sqrt(n)) * 0.5 * steps / (n - 1.0);
  return std::sqrt(std::max(0.0, squares / n - noise) / 8.0) / circle.radius;
}

/// Error for inconsistent readings. Finds the cause: lag (exposed before the SLM had settled),
/// drift of the bench, or too much noise.
Error diagnose(std::span<const GreyBeat> beats, const Circle& circle, double noise_rad,
               double drift_rad) {
  double lag = 0.0, square = 0.0;
  for (const GreyBeat& beat : beats) {
    const double off =
        std::arg((beat.second - circle.middle) * std::conj(beat.first - circle.middle));
    lag += off / double(beats.size());
    square += off * off / double(beats.size());
  }
  if (std::abs(lag) > kMinLagRatio * std::sqrt(square)) {
    return {
        Errc::refused, "slm.settle_ms",
        "the phases measured with rising and with falling grey levels differ by " +
            with_decimals(std::abs(lag), 2) +
            " rad: the SLM is slower than slm.settle_ms, or the bench moves; slm.settle measures "
            "the settle time"};
  }
  if (drift_rad > kMaxDriftRad) {
    return {Errc::refused, "",
            "the bench moved during the measurement: beyond the noise, the two readings of a level "
            "differ by " +
                with_decimals(2.0 * drift_rad, 3) + " rad RMS (at most " +
                with_decimals(2.0 * kMaxDriftRad, 3) +
                " are allowed): let the bench come to rest and measure again"};
  }
  return {Errc::refused, "camera.exposure_us",
          "the fringes are too weak: the phase noise of one level is " +
              with_decimals(noise_rad, 2) + " rad; raise the exposure, or average more frames"};
}

Result<void> check_steady(std::span<const GreyBeat> beats, const Circle& circle, double noise_rad) {
  const double drift_rad = drift_of(beats, circle);
  if (noise_rad <= kMaxNoiseRad && drift_rad <= kMaxDriftRad) return {};
  return fail(diagnose(beats, circle, noise_rad, drift_rad));
}

Result<void> check_monotonic(std::span<const GreyBeat> beats, const std::vector<double>& phases,
                             double noise_rad) {
  std::size_t top = 0;
  for (std::size_t k = 1; k < phases.size(); ++k) {
    if (phases[k] > phases[top]) top = k;
    if (phases[top] - phases[k] < kFallSigmas * std::sqrt(2.0) * noise_rad) continue;
    return fail(
        Errc::refused, "",
        "the phase is not monotonic: it reverses by " + with_decimals(phases[top] - phases[k], 2) +
            " rad from grey level " + std::to_string(beats[top].grey) + " to " +
            std::to_string(beats[k].grey) +
            ", which no look-up table can correct; check that nothing moves on the bench, and "
            "that the SLM's own voltage range and gamma curve give a monotonic phase");
  }
  return {};
}

/// Roughness penalty of 256 phases: integrated squared third derivative with respect to the index
/// of the measured level, so that the curve may bend more where measured levels are dense. The
/// weight of a squared third difference is the fifth power of the level gap, 1 for the widest gap.
Eigen::MatrixXd roughness_penalty(std::span<const GreyBeat> beats) {
  Eigen::VectorXd gap(253);  // between measured levels, at the middle of k .. k + 3
  std::size_t next = 1;
  for (int k = 0; k < 253; ++k) {
    while (beats[next].grey < k + 2) ++next;
    gap[k] = beats[next].grey - beats[next - 1].grey;
  }
  Eigen::MatrixXd differences = Eigen::MatrixXd::Zero(253, 256);
  for (Eigen::Index k = 0; k < 253; ++k) {
    differences.row(k).segment(k, 4) << -1.0, 3.0, -3.0, 1.0;
    differences.row(k) *= std::pow(gap[k] / gap.maxCoeff(), 2.5);
  }
  return gram_matrix(differences);
}

struct Curve {
  Eigen::VectorXd phases, standard_error;
  double residual = 0.0;
};

/// Whittaker smoothing: returns the stiffest curve whose RMS residual does not exceed the noise.
Curve whittaker_smooth(std::span<const GreyBeat> beats, const std::vector<double>& phases,
                       double noise_rad) {
  const Eigen::MatrixXd bend = roughness_penalty(beats);
  Curve curve;
  for (double stiffness = kMaxStiffness; stiffness >= kMinStiffness; stiffness /= 3.0) {
    Eigen::MatrixXd normal = stiffness / (noise_rad * noise_rad) * bend;
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(256);
    for (std::size_t k = 0; k < beats.size(); ++k) {
      normal(beats[k].grey, beats[k].grey) += 1.0 / (noise_rad * noise_rad);
      rhs[beats[k].grey] += phases[k] / (noise_rad * noise_rad);
    }
    curve.phases = solve_symmetric(normal, rhs);
    double sum = 0.0;
    for (std::size_t k = 0; k < beats.size(); ++k) {
      sum += std::pow(curve.phases[beats[k].grey] - phases[k], 2);
    }
    curve.residual = std::sqrt(sum / double(beats.size()));
    const bool last = stiffness / 3.0 < kMinStiffness;
    if (curve.residual > noise_rad && !last) continue;
    const Eigen::MatrixXd inverse =
        solve_symmetric(normal, Eigen::MatrixXd(Eigen::MatrixXd::Identity(256, 256)));
    // If even the softest curve fits worse than the noise, scale the errors up to the residual.
    const double excess = std::max(1.0, curve.residual / noise_rad);
    // Variance of each level's phase difference from grey level 0.
    const Eigen::ArrayXd variance =
        inverse.diagonal().array() + inverse(0, 0) - 2.0 * inverse.col(0).array();
    curve.standard_error = excess * variance.max(0.0).sqrt();
    break;
  }
  return curve;
}

}  // namespace

Result<std::vector<int>> levels_between(std::span<const GreyBeat> beats) {
  const auto circle = checked_circle(beats);
  if (!circle) return fail(circle.error());
  const double noise = noise_of(beats, *circle);
  if (auto steady = check_steady(beats, *circle, noise); !steady) return fail(steady.error());
  std::vector<int> between;
  for (std::size_t k = 1; k < beats.size(); ++k) {
    const int low = beats[k - 1].grey, gap = beats[k].grey - low;
    const double steps = std::ceil(std::abs(turn_rad(beats, *circle, k)) / kMaxStepRad);
    const int parts = std::min(int(steps), gap);
    for (int i = 1; i < parts; ++i) between.push_back(low + gap * i / parts);
  }
  return between;
}

Result<PhaseResponse> phase_response(std::span<const GreyBeat> beats) {
  const auto circle = checked_circle(beats);
  if (!circle) return fail(circle.error());
  const double noise = noise_of(beats, *circle);
  if (auto steady = check_steady(beats, *circle, noise); !steady) return fail(steady.error());
  const std::vector<double> phases = unwrapped(beats, *circle);
  if (auto rising = check_monotonic(beats, phases, noise); !rising) return fail(rising.error());
  if (phases.back() < kMinDepthRad) {
    return fail(Errc::refused, "",
                "the SLM's phase range is only " + with_decimals(phases.back(), 2) +
                    " rad: check that the configured output is the SLM");
  }
  const Curve curve = whittaker_smooth(beats, phases, noise);
  PhaseResponse response;
  response.levels = int(beats.size());
  response.noise_rad = noise;
  response.residual_rad = curve.residual;
  double highest = 0.0;
  for (std::size_t g = 0; g < 256; ++g) {
    const auto at = Eigen::Index(g);
    highest = std::max(highest, curve.phases[at] - curve.phases[0]);
    response.phase_rad[g] = highest;
    response.standard_error_rad[g] = curve.standard_error[at];
  }
  return response;
}

std::array<double, 256> negative(std::array<double, 256> phase_rad) {
  for (double& phase : phase_rad) phase = 0.0 - phase;
  return phase_rad;
}

Result<PhaseResponse> with_sign(PhaseResponse response, const BlazedLight& rising,
                                const BlazedLight& falling) {
  const double up = 0.5 * (rising.first_dn + rising.second_dn);
  const double down = 0.5 * (falling.first_dn + falling.second_dn);
  const double spread = std::max(std::abs(rising.first_dn - rising.second_dn),
                                 std::abs(falling.first_dn - falling.second_dn));
  if (std::abs(up - down) <= std::max(kMinBlaze * std::max(up, down), kBlazeNoises * spread)) {
    return fail(Errc::refused, "camera.exposure_us",
                "cannot determine whether the phase rises or falls with the grey level: a "
                "blazed grating brings " +
                    with_decimals(up, 2) + " DN to the base spot if it rises and " +
                    with_decimals(down, 2) +
                    " DN if it falls; run registration.run, raise the exposure, or average more "
                    "frames");
  }
  if (down > up) response.phase_rad = negative(response.phase_rad);
  return response;
}

PhaseTable linearising_lut(const std::array<double, 256>& phase_rad) {
  if (phase_rad.back() < 0.0) {
    PhaseTable table = linearising_lut(negative(phase_rad));
    // Reverse the steps, because the phase -2 pi k/256 equals 2 pi (256 - k)/256 modulo 2 pi.
    std::reverse(table.lut.begin() + 1, table.lut.end());
    return table;
  }
  constexpr double kStep = kTwoPi / 256.0;
  PhaseTable table;
  const double depth = phase_rad.back();
  for (std::size_t k = 0; k < table.lut.size(); ++k) {
    const double wanted = kStep * double(k);
    if (wanted > depth) {
      const double to_last = wanted - depth, to_first = kTwoPi - wanted;
      table.lut[k] = to_last <= to_first ? 255 : 0;
      if (std::min(to_last, to_first) > 0.5 * kStep) ++table.steps_out_of_reach;
      continue;
    }
    const auto above = std::lower_bound(phase_rad.begin(), phase_rad.end(), wanted);
    auto grey = above - phase_rad.begin();
    if (grey > 0 && wanted - phase_rad[std::size_t(grey - 1)] < *above - wanted) --grey;
    table.lut[k] = std::uint8_t(grey);
  }
  if (table.steps_out_of_reach > 0) {
    table.reason = "the SLM reaches " + with_decimals(depth / std::numbers::pi, 2) +
                   " pi of 2 pi: phases beyond are shown by grey level 255 or 0, whichever is "
                   "nearer";
  }
  return table;
}

}  // namespace ovws

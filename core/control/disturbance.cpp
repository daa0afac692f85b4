#include "core/control/disturbance.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>
#include <utility>

#include "core/base/median.hpp"

namespace ovws {
namespace {

constexpr std::array kDampings{1.0, 0.3, 0.1, 0.03};
constexpr double kRatio = 1.25;                   // between the natural frequencies of the set
constexpr std::array kLineWidths{0.5, 1.0, 2.0};  // of a line (damping times frequency), bins
constexpr double kLeastWidth = 2.0;  // of the other parts, bins: narrower ones would fit the noise
constexpr double kPeak = 4.0;        // power of a line's bin over the median around it
constexpr int kAround = 8;           // bins on either side for that median
constexpr double kBandRatio = 1.02;  // between a band's limits; no part is as narrow
constexpr int kFirstUpdates = 200, kLastUpdates = 100;
constexpr double kLeastShare = 0.02;  // of the power in a part's own best band: less is left out

/// Whether bin `k` stands out of the bins around it and is their greatest.
bool is_peak(const std::vector<double>& power, std::size_t k) {
  const std::size_t from = k < kAround ? 0 : k - kAround;
  const std::size_t to = std::min(power.size(), k + kAround + 1);
  std::vector<double> around(power.begin() + std::ptrdiff_t(from),
                             power.begin() + std::ptrdiff_t(to));
  return power[k] > kPeak * median(around) &&
         power[k] >= *std::max_element(around.begin(), around.end());
}

std::vector<std::size_t> peaks_of(const Spectrum& spectrum) {
  std::vector<std::size_t> peaks;
  for (std::size_t k = kAround / 2; k < spectrum.power_per_hz.size(); ++k) {
    if (is_peak(spectrum.power_per_hz, k)) peaks.push_back(k);
  }
  return peaks;
}

/// The set of oscillators, each with an RMS of 1.
std::vector<Oscillator> candidates(const Spectrum& spectrum, std::span<const std::size_t> peaks) {
  std::vector<Oscillator> all;
  // Above half of the highest frequency, a broad part looks like noise.
  const double last_hz = 0.5 * spectrum.hz(spectrum.power_per_hz.size() - 1);
  for (const double damping : kDampings) {
    for (double hz = 0.5 * spectrum.step_hz; hz < last_hz; hz *= kRatio) {
      if (damping == 1.0 || damping * hz >= kLeastWidth * spectrum.step_hz) {
        all.push_back({hz, damping, 1.0});
      }
    }
  }
  for (const std::size_t k : peaks) {
    const double hz = spectrum.hz(k);
    for (const double width : kLineWidths) all.push_back({hz, width * spectrum.step_hz / hz, 1.0});
  }
  return all;
}

/// Power densities averaged over bands of about kBandRatio, and over single bins around peaks.
struct Bands {
  Eigen::ArrayXd hz, power_per_hz;
  Eigen::ArrayXd bins;  ///< number of bins in each
};

Bands bands_of(const Spectrum& spectrum, std::span<const std::size_t> peaks, double least_per_hz) {
  const std::size_t count = spectrum.power_per_hz.size();
  std::vector<char> single(count + 1, 0);
  for (const std::size_t k : peaks) {
    const std::size_t from = k < kAround ? 0 : k - kAround;
    std::fill(single.begin() + std::ptrdiff_t(from),
              single.begin() + std::ptrdiff_t(std::min(count, k + kAround + 1)), char(1));
  }
  std::vector<double> hz, power, bins;
  for (std::size_t first = 0, end = 0; first < count; first = end) {
    double sum = 0.0;
    do sum += std::max(spectrum.power_per_hz[end++], least_per_hz);
    while (end < count && !single[first] && !single[end] &&
           spectrum.hz(end) < kBandRatio * spectrum.hz(first));
    hz.push_back(0.5 * (spectrum.hz(first) + spectrum.hz(end - 1)));
    bins.push_back(double(end - first));
    power.push_back(sum / bins.back());
  }
  const auto array = [](const std::vector<double>& of) {
    return Eigen::ArrayXd(Eigen::Map<const Eigen::ArrayXd>(of.data(), Eigen::Index(of.size())));
  };
  return {array(hz), array(power), array(bins)};
}

/// Power density as Welch's method sees it: a Hann window spreads it over three bins.
double seen_per_hz(const Oscillator& part, double hz, double step_hz, double step_s) {
  const auto density = [&](double at) { return part.sampled_power_per_hz(at, step_s); };
  return (density(hz - step_hz) + 4.0 * density(hz) + density(hz + step_hz)) / 6.0;
}

/// Power densities of the oscillators (columns) in the bands; the last column is that of noise with
/// an RMS of 1.
Eigen::MatrixXd band_densities(const std::vector<Oscillator>& parts, const Bands& bands,
                               double step_hz, double step_s) {
  Eigen::MatrixXd all(bands.hz.size(), Eigen::Index(parts.size()) + 1);
  for (Eigen::Index k = 0; k < bands.hz.size(); ++k) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      all(k, Eigen::Index(i)) = seen_per_hz(parts[i], bands.hz[k], step_hz, step_s);
    }
  }
  all.rightCols(1).setConstant(2.0 * step_s);
  return all;
}

/// Improves the powers `of` the columns of `densities`; the last one stays at least `least`.
void update(const Eigen::MatrixXd& densities, const Bands& bands, double least, int count,
            Eigen::ArrayXd& of) {
  for (int k = 0; k < count; ++k) {
    const Eigen::ArrayXd model = (densities * of.matrix()).array();
    const Eigen::ArrayXd weights = bands.bins / model;
    const Eigen::ArrayXd found = weights * bands.power_per_hz / model;
    of *= (densities.transpose() * found.matrix()).array() /
          (densities.transpose() * weights.matrix()).array();
    of.tail(1) = of.tail(1).max(least);
  }
}

/// Makes one line of each peak's lines of several widths, with their power and, far from the peak,
/// the same power density. `lines`: index of the first line.
void merge_lines(std::size_t lines, std::vector<Oscillator>& parts, Eigen::ArrayXd& of) {
  constexpr std::size_t kWidths = kLineWidths.size();
  constexpr double kLeastPower = 1e-30;  // wave^2: the updates may leave none
  std::size_t next = lines;
  for (std::size_t i = lines; i < parts.size(); i += kWidths, ++next) {
    double power = kLeastPower, damped = kLeastPower * parts[i].damping;
    for (std::size_t k = i; k < i + kWidths; ++k) {
      power += of[Eigen::Index(k)];
      damped += of[Eigen::Index(k)] * parts[k].damping;
    }
    parts[next] = {parts[i].hz, damped / power, 1.0};
    of[Eigen::Index(next)] = power;
  }
  of[Eigen::Index(next)] = of.tail(1)[0];
  parts.resize(next);
  of.conservativeResize(Eigen::Index(next) + 1);
}

/// Largest share of each part in the power density of any band.
Eigen::ArrayXd best_shares(const Eigen::MatrixXd& densities, const Eigen::ArrayXd& of) {
  const Eigen::ArrayXd all = (densities * of.matrix()).array();
  return of * (densities.array().colwise() / all).colwise().maxCoeff().transpose();
}

}  // namespace

double Disturbance::rms_waves() const {
  double squares = 0.0;
  for (const Oscillator& part : parts) squares += part.rms_waves * part.rms_waves;
  return std::sqrt(squares);
}

double Disturbance::sampled_power_per_hz(double hz, double step_s) const {
  double sum = 0.0;
  for (const Oscillator& part : parts) sum += part.sampled_power_per_hz(hz, step_s);
  return sum;
}

Disturbance identify(const Spectrum& spectrum, double step_s, double sigma_waves) {
  constexpr double kLeastNoise = 1e-6;  // waves: keeps the spectrum of the model above 0
  const double least = std::pow(std::max(sigma_waves, kLeastNoise), 2);
  if (spectrum.power_per_hz.empty()) return {{}, std::sqrt(least)};
  const double least_per_hz = 2.0 * step_s * kLeastNoise * kLeastNoise;
  const std::vector<std::size_t> peaks = peaks_of(spectrum);
  const Bands bands = bands_of(spectrum, peaks, least_per_hz);
  std::vector<Oscillator> parts = candidates(spectrum, peaks);
  const double power = (bands.power_per_hz * bands.bins).sum() * spectrum.step_hz;
  Eigen::ArrayXd of =
      Eigen::ArrayXd::Constant(Eigen::Index(parts.size()) + 1, power / double(parts.size()));
  of.tail(1) = least;
  update(band_densities(parts, bands, spectrum.step_hz, step_s), bands, least, kFirstUpdates, of);
  merge_lines(parts.size() - kLineWidths.size() * peaks.size(), parts, of);

  const Eigen::ArrayXd share =
      best_shares(band_densities(parts, bands, spectrum.step_hz, step_s), of);
  std::vector<Eigen::Index> order(parts.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](auto a, auto b) { return share[a] > share[b]; });
  std::vector<Oscillator> strongest;
  std::vector<double> powers;
  for (const Eigen::Index i : order) {
    if (int(strongest.size()) == Disturbance::kMaxParts || !(share[i] > kLeastShare)) break;
    strongest.push_back(parts[std::size_t(i)]);
    powers.push_back(of[i]);
  }
  powers.push_back(of.tail(1)[0]);
  Eigen::ArrayXd kept = Eigen::Map<Eigen::ArrayXd>(powers.data(), Eigen::Index(powers.size()));
  update(band_densities(strongest, bands, spectrum.step_hz, step_s), bands, least, kLastUpdates,
         kept);
  for (std::size_t i = 0; i < strongest.size(); ++i) {
    strongest[i].rms_waves = std::sqrt(kept[Eigen::Index(i)]);
  }
  std::ranges::sort(strongest, std::greater(), &Oscillator::rms_waves);
  return {std::move(strongest), std::sqrt(kept.tail(1)[0])};
}

}  // namespace ovws

/// Templates against the Cramer-Rao bound, and against images of other models.
#include <Eigen/Core>
#include <Eigen/LU>
#include <complex>
#include <cstdio>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "core/spots/point_model.hpp"
#include "tests/unit/spots/templates_case.hpp"

namespace ovws {
namespace {

double read_noise_of(double snr) {
  return std::sqrt(std::max(0.0, kPeakE * kPeakE / (snr * snr) - kPeakE));
}

/// Gauss-Newton: every rendering is about what the last one found.
Waves fitted(SpotRenderer& renderer, const ImageView& image, const PixelNoise& noise, Waves waves,
             int renderings) {
  for (int k = 0; k < renderings; ++k) {
    const auto step = step_from(fit_spots(image, renderer.render(waves), noise, kMaxSpotEstimates));
    if (!step) return Waves(waves.size(), NAN);
    for (std::size_t j = 0; j < waves.size(); ++j) waves[j] += step->waves(Eigen::Index(j));
  }
  return waves;
}

/// The image without noise, in 16 bits.
Image<std::uint16_t> bright(const Image<float>& light) {
  constexpr double kBrightestDn = 50'000.0;
  const float brightest = *std::max_element(light.pixels.begin(), light.pixels.end());
  Image<std::uint16_t> dn(light.width, light.height);
  for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
    const double share = double(light.pixels[k]) / double(brightest);
    dn.pixels[k] = std::uint16_t(std::lround(kBrightestDn * share));
  }
  return dn;
}

class Accuracy : public Templates {};

/// The Cramer-Rao bound of all pixels within 4 lambda/d of a spot, at one wavefront of charge 1,
/// from central differences of the diffraction model; light and background are unknown, too. The
/// step is large because the model rounds phases to 8 bits.
class AllPixels {
 public:
  AllPixels(const Waves& truth, const Image<float>& light, std::span<const RenderedSpot> spots)
      : light_(Eigen::Map<const Eigen::VectorXf>(light.pixels.data(),
                                                 Eigen::Index(light.pixels.size()))),
        per_unknown_(light_.size(), Eigen::Index(truth.size()) + 2) {
    constexpr double kStepWaves = 0.08;
    near_.setZero(light_.size());
    for (const RenderedSpot& spot : spots) add_near(spot.place_px, light.width, light.height);
    const double level = light_.sum() / float(total(intensity(truth)));
    for (std::size_t k = 0; k < truth.size(); ++k) {
      Waves more = truth, less = truth;
      more[k] += kStepWaves, less[k] -= kStepWaves;
      const Image<float> above = intensity(more), below = intensity(less);
      for (std::size_t i = 0; i < above.pixels.size(); ++i) {
        per_unknown_(Eigen::Index(i), Eigen::Index(k)) =
            float(level / (2.0 * kStepWaves)) * (above.pixels[i] - below.pixels[i]);
      }
    }
    per_unknown_.rightCols(2) << light_, Eigen::VectorXf::Ones(light_.size());
  }

  /// RMS over j >= 3.
  double bound(double read_noise_e) const {
    const Eigen::VectorXf weights =
        (near_.array() / (light_.array() + float(read_noise_e * read_noise_e))).matrix();
    const Eigen::MatrixXf weighted = weights.asDiagonal() * per_unknown_;
    const Eigen::MatrixXd fisher = (per_unknown_.transpose() * weighted).cast<double>();
    const Eigen::VectorXd variances = fisher.inverse().diagonal();
    return std::sqrt(variances.segment(2, variances.size() - 4).sum());
  }

 private:
  void add_near(Vec2 place_px, int width, int height) {
    const double reach_px = 4.0 * Templates::model(1).lambda_d_px();
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const Vec2 off = Vec2{double(x), double(y)} - place_px;
        const bool near = std::max(std::abs(off.x), std::abs(off.y)) < reach_px;
        if (near) near_(Eigen::Index(y) * width + x) = 1.0F;
      }
    }
  }

  static Image<float> intensity(const Waves& waves) {
    std::vector<Mode> modes;
    for (std::size_t k = 0; k < waves.size(); ++k) modes.push_back({int(k) + 1, waves[k]});
    return Templates::model(1).intensity(modes).value();
  }

  Eigen::VectorXf light_, near_;
  Eigen::MatrixXf per_unknown_;
};

/// Camera of this peak SNR, one electron a DN.
struct Noisy {
  double read_noise_e, black_dn;
  PixelNoise noise;
  explicit Noisy(double snr)
      : read_noise_e(read_noise_of(snr)),
        black_dn(std::ceil(4.0 * read_noise_e)),
        noise{read_noise_e * read_noise_e + 1.0 / 12.0, 1.0} {}
};

/// Standard deviation of each estimate over noisy images, RMS over all spots.
Eigen::ArrayXd scatter_of_estimates(std::span<const RenderedSpot> rendered,
                                    const Image<float>& electrons, const Noisy& camera) {
  constexpr int kImages = 60;
  std::vector<Eigen::MatrixXd> values(rendered.size(), Eigen::MatrixXd(kMaxSpotEstimates, kImages));
  std::optional<SpotFit> fit;
  for (int k = 0; k < kImages; ++k) {
    const auto image =
        Templates::exposed(electrons, camera.read_noise_e, unsigned(k) + 1, camera.black_dn);
    const ImageView view = Templates::view(image);
    if (!fit) fit.emplace(fit_spots(view, rendered, camera.noise, kMaxSpotEstimates).templates);
    auto scratch = fit->make_scratch();
    for (std::size_t i = 0; i < rendered.size(); ++i) {
      const SpotEstimates found = fit->fit(view, i, scratch);
      const SpotWindow& window = fit->spots()[i].window;
      const Eigen::Map<const Eigen::VectorXf> unit(found.values.data(), kMaxSpotEstimates);
      values[i].col(k) = double(found.level) * window.bin * window.bin * unit.cast<double>();
    }
  }
  Eigen::ArrayXd squares = Eigen::ArrayXd::Zero(kMaxSpotEstimates);
  for (const Eigen::MatrixXd& of_spot : values) {
    const Eigen::VectorXd mean = of_spot.rowwise().mean();
    squares += (of_spot.colwise() - mean).array().square().rowwise().sum();
  }
  return (squares / double((kImages - 1) * rendered.size())).sqrt();
}

/// Estimates are made to have an error of 1 in the assumed noise, which is their bound.
TEST_F(Accuracy, AllEstimatesOfASpotReachTheirBound) {
  const Waves flat(44, 0.0);
  for (const int charge : {0, 1, 2}) {
    const auto rendered = renderer(charge, 44).render(flat);
    const Image<float> electrons = light(charge, flat);
    for (const double snr : {3.0, 7.0, 22.0}) {
      const Eigen::ArrayXd scatter = scatter_of_estimates(rendered, electrons, Noisy(snr));
      std::printf("  charge %d, SNR %2.0f: estimates scatter by %.3f to %.3f of their bounds\n",
                  charge, snr, scatter.minCoeff(), scatter.maxCoeff());
      EXPECT_LT(scatter.maxCoeff(), 1.10);
      EXPECT_GT(scatter.minCoeff(), 0.90);
    }
  }
}

/// A wavefront, and the error of the modes over the bound that it may have.
struct Whole {
  int modes;
  double rms, snr;
  double factor;
};

/// RMS error of frames over j >= 3. As in the daemon, a search in one noisy image, from a start
/// that is 0.04 wave off, gives the templates; other images are measured by them.
double error_of_frames(PointModel& model, const Waves& truth, const Image<float>& electrons,
                       const Noisy& camera) {
  constexpr unsigned kSearches = 3, kImages = 10;
  double squares = 0.0;
  for (unsigned search = 0; search < kSearches; ++search) {
    std::vector<Waves> starts{Accuracy::random(int(truth.size()), 0.04, 6 + search)};
    for (std::size_t k = 0; k < truth.size(); ++k) starts[0][k] += truth[k];
    const auto searched =
        Accuracy::exposed(electrons, camera.read_noise_e, 1000 + search, camera.black_dn);
    const auto fit = model.templates(Accuracy::view(searched), camera.noise, starts, {}, 8).value();
    for (unsigned k = 0; k < kImages; ++k) {
      const auto image = Accuracy::exposed(electrons, camera.read_noise_e, kImages * search + k + 1,
                                           camera.black_dn);
      const auto frame = Accuracy::measured(*fit, Accuracy::view(image));
      EXPECT_TRUE(frame.fitted.credible);
      squares += std::pow(Accuracy::error(frame.waves, truth), 2) / (kSearches * kImages);
    }
  }
  return std::sqrt(squares);
}

TEST_F(Accuracy, TheWholeSensorIsNearTheBoundOfAllPixels) {
  std::map<std::pair<int, double>, AllPixels> bounds;
  for (const auto& [modes, rms, snr, factor] : {Whole{18, 0.0, 3.0, 1.15},
                                                {18, 0.0, 22.0, 1.15},
                                                {18, 0.3, 3.0, 1.15},
                                                {18, 0.3, 7.0, 1.15},
                                                {18, 0.3, 22.0, 1.15},
                                                {44, 0.0, 3.0, 1.25},
                                                {44, 0.0, 22.0, 1.25},
                                                {44, 0.3, 3.0, 1.25},
                                                {44, 0.3, 7.0, 1.25},
                                                {44, 0.3, 22.0, 1.25}}) {
    const Waves truth = rms > 0.0 ? random(modes, rms, 5) : Waves(modes, 0.0);
    const Image<float> electrons = light(1, truth);
    const double half_width = window_half_width(modes, sensor_of(1).subapertures_across);
    PointModel model(renderer(1, modes, half_width), kMaxSpotEstimates);
    const Noisy camera(snr);
    const double found = error_of_frames(model, truth, electrons, camera);
    const auto& all =
        bounds.try_emplace({modes, rms}, truth, electrons, model.rendered(truth)).first->second;
    const double best = all.bound(camera.read_noise_e);
    std::printf("  %d modes, %.1f wave, SNR %2.0f: %.5f wave, %.2f of the bound\n", modes, rms, snr,
                found, found / best);
    EXPECT_LT(found, factor * best) << modes << " modes, " << rms << " wave, SNR " << snr;
  }
}

TEST_F(Accuracy, EverySingleModeIsMeasuredAfterTwoRefreshes) {
  double worst = 0.0;
  for (const auto& [modes, waves] : {std::pair{18, 0.3}, {44, 0.1}}) {
    SpotRenderer spots = renderer(1, modes);
    for (int j = 3; j <= modes; ++j) {
      Waves truth(modes, 0.0), start(modes, 0.0);
      truth[std::size_t(j - 1)] = waves;
      start[std::size_t(j - 1)] = 0.9 * waves;  // positions err by less
      const auto image = bright(light(1, truth));
      const Waves found = fitted(spots, view(image), {100.0, 1.0}, start, 3);
      worst = std::max(worst, error(found, truth));
      EXPECT_LT(error(found, truth), 0.003) << "j = " << j << " of " << modes;
    }
  }
  std::printf("  worst of 0.3 wave of j = 3 to 18, and 0.1 wave of j = 3 to 44: %.5f wave\n",
              worst);
}

/// Spots move over a pixel, in light with 0, 0.033 and 0.066 wave of astigmatism in each
/// subaperture (2 and 4 waves at the pupil's edge). Templates are rendered again as they move.
TEST_F(Accuracy, SpotsAreFoundAtEveryPlaceInAPixel) {
  constexpr int kModes = 18, kPlaces = 8;
  SpotRenderer spots = renderer(1, kModes);
  // A tilt of w waves RMS has a slope of 2 w waves per pupil radius.
  const double px_per_wave =
      2.0 * camera_px_per_cycle({}, {}) / (0.5 * sensor_of(1).pupil_diameter_px);
  double worst_px = 0.0;
  for (const double edge_waves : {0.0, 2.0, 4.0}) {
    for (int k = 0; k < kPlaces; ++k) {
      Waves truth(kModes, 0.0);
      truth[0] = (double(k) / kPlaces - 0.5) / px_per_wave;
      truth[1] = (double(3 * k % kPlaces) / kPlaces - 0.5) / px_per_wave;
      truth[2] = edge_waves / std::sqrt(6.0);
      Waves start = truth;
      start[0] = start[1] = 0.0;
      const auto image = bright(light(1, truth));
      const Waves found = fitted(spots, view(image), {100.0, 1.0}, start, 3);
      for (const int tilt : {0, 1}) {
        worst_px = std::max(worst_px, px_per_wave * std::abs(found[tilt] - truth[tilt]));
      }
    }
  }
  std::printf("  worst position over a pixel: %.5f px\n", worst_px);
  EXPECT_LT(worst_px, 0.002);
}

/// The paper's equations 1 to 4, written down again: a phase for every SLM pixel, and its Fourier
/// transform as sums in double precision.
class Paper {
 public:
  static constexpr int kColumns = 1280, kRows = 768, kPupilPx = 768, kAcross = 5;

  /// Light of every camera pixel.
  static Image<float> image(int charge, const std::vector<double>& waves) {
    const Eigen::MatrixXcd field = field_of(charge, waves);
    const double px_per_cycle = 632e-9 * 0.2 / (19e-6 * 3.45e-6);
    const auto kernel = [&](double grooves, int size) {
      Eigen::MatrixXcd turn(kImagePx, size);
      for (int c = 0; c < kImagePx; ++c) {
        const double u = grooves / size + (c - 0.5 * (kImagePx - 1)) / px_per_cycle;
        for (int x = 0; x < size; ++x) turn(c, x) = turned(-u * (x - 0.5 * (size - 1)));
      }
      return turn;
    };
    const Eigen::MatrixXcd far = kernel(20.0, kRows) * field * kernel(200.0, kColumns).transpose();
    Image<float> light(kImagePx, kImagePx);
    for (int r = 0; r < kImagePx; ++r) {
      for (int c = 0; c < kImagePx; ++c) light.at(c, r) = float(std::norm(far(r, c)));
    }
    return light;
  }

 private:
  static std::complex<double> turned(double cycles) {
    return std::polar(1.0, 2.0 * std::numbers::pi * cycles);
  }

  /// RMS-normalised Zernike polynomial, by its sum over powers of the radius.
  class Polynomial {
   public:
    explicit Polynomial(int j) {
      while ((n_ + 1) * (n_ + 2) / 2 <= j) ++n_;
      m_ = 2 * j - n_ * (n_ + 2);
      const int k = std::abs(m_);
      const double norm = std::sqrt((m_ == 0 ? 1.0 : 2.0) * (n_ + 1));
      for (int s = 0; s <= (n_ - k) / 2; ++s) {
        const double sign = s % 2 == 0 ? 1.0 : -1.0;
        factors_.push_back(norm * sign * std::tgamma(n_ - s + 1.0) /
                           (std::tgamma(s + 1.0) * std::tgamma((n_ + k) / 2 - s + 1.0) *
                            std::tgamma((n_ - k) / 2 - s + 1.0)));
      }
    }
    double operator()(double radius, double angle) const {
      double sum = 0.0, power = std::pow(radius, std::abs(m_));
      for (auto factor = factors_.rbegin(); factor != factors_.rend(); ++factor) {
        sum += *factor * power;
        power *= radius * radius;
      }
      return sum * (m_ < 0 ? std::sin(-m_ * angle) : std::cos(m_ * angle));
    }

   private:
    int n_ = 0, m_ = 0;
    std::vector<double> factors_;  // of radius^n, radius^(n-2) …
  };

  static Eigen::MatrixXcd field_of(int charge, const std::vector<double>& waves) {
    constexpr double kD = double(kPupilPx) / kAcross, kSpacing = 0.25;
    std::vector<Polynomial> modes;
    for (std::size_t k = 0; k < waves.size(); ++k) modes.emplace_back(int(k) + 1);
    Eigen::MatrixXcd field = Eigen::MatrixXcd::Ones(kRows, kColumns);
    for (int q = -2; q <= 2; ++q) {
      for (int p = -2; p <= 2; ++p) {
        if (std::abs(p + q) > 2) continue;
        const double centre_x = kD * (p + 0.5 * q), centre_y = kD * q * std::sqrt(0.75);
        for (int r = 0; r < kRows; ++r) {
          for (int c = 0; c < kColumns; ++c) {
            const double x = c - 0.5 * (kColumns - 1), y = r - 0.5 * (kRows - 1);
            const double from_x = x - centre_x, from_y = y - centre_y;
            if (std::hypot(from_x, from_y) > 0.5 * kD) continue;
            double cycles = charge * std::atan2(from_y, from_x) / (2.0 * std::numbers::pi) +
                            (200.0 + kSpacing * centre_x) / kColumns * x +
                            (20.0 + kSpacing * centre_y) / kRows * y;
            const double radius = 2.0 * std::hypot(x, y) / kPupilPx, angle = std::atan2(y, x);
            for (std::size_t k = 0; k < waves.size(); ++k)
              cycles += waves[k] * modes[k](radius, angle);
            field(r, c) = turned(cycles);
          }
        }
      }
    }
    return field;
  }
};

TEST_F(Accuracy, AnImageByThePapersEquationsIsMeasuredAsWell) {
  struct Case {
    int charge, modes;
    double rms;
  };
  for (const auto& [charge, modes, rms] :
       {Case{1, 18, 0.3}, {1, 44, 0.1}, {2, 18, 0.3}, {0, 18, 0.3}}) {
    const Waves truth = random(modes, rms, 3), off = random(modes, 0.03, 4);
    Waves start = truth;
    for (std::size_t k = 0; k < start.size(); ++k) start[k] += off[k];
    SpotRenderer spots = renderer(charge, modes);
    const auto own = bright(light(charge, truth)), papers = bright(Paper::image(charge, truth));
    const double from_own = error(fitted(spots, view(own), {100.0, 1.0}, start, 3), truth);
    const double from_papers = error(fitted(spots, view(papers), {100.0, 1.0}, start, 3), truth);
    std::printf(
        "  charge %d, %d modes, %.1f wave: %.5f wave by the paper's equations, %.5f by ours\n",
        charge, modes, rms, from_papers, from_own);
    EXPECT_LT(from_papers, 0.001);
  }
}

}  // namespace
}  // namespace ovws

// Templates for a colour camera use only the pixels whose filter passes the laser.
#include <cmath>
#include <cstdio>

#include "core/spots/measured_spots.hpp"
#include "tests/unit/spots/templates_case.hpp"

namespace ovws {
namespace {

constexpr float kCrosstalk = 0.05F;  // of the laser, through filters of other colours

struct Colour {
  PixelFormat format;
  double wavelength_nm;
  int modes;
  double rms_waves;

  LitPixels lit() const { return lit_pixels(format, wavelength_nm); }
};

class ColourTemplates : public Templates, public testing::WithParamInterface<Colour> {
 public:
  static Image<float> filtered(Image<float> light, const LitPixels& lit) {
    for (int y = 0; y < light.height; ++y) {
      for (int x = 0; x < light.width; ++x) {
        if (!lit.has(x, y)) light.at(x, y) *= kCrosstalk;
      }
    }
    return light;
  }
  static PointModel model_of(const Colour& camera) {
    const double half_width = window_half_width(camera.modes, sensor_of(1).subapertures_across);
    return {renderer(1, camera.modes, half_width, camera.lit()), kMaxSpotEstimates};
  }
};

TEST_P(ColourTemplates, MeasureAsWellAsTheirErrorsSay) {
  constexpr unsigned kImages = 12;
  const Colour camera = GetParam();
  const Waves truth = random(camera.modes, camera.rms_waves, 5);
  const Image<float> electrons = filtered(light(1, truth), camera.lit());
  const auto searched = exposed(electrons, kReadNoiseE, 100);
  PointModel model = model_of(camera);
  const std::vector<Waves> starts{Waves(std::size_t(camera.modes), 0.0)};
  const auto fit = model.templates(view_of(searched, camera.format), starts, {}, 20);
  ASSERT_TRUE(fit) << fit.error().reason;
  double squares = 0.0, expected = 0.0;
  for (unsigned k = 0; k < kImages; ++k) {
    const auto image = exposed(electrons, kReadNoiseE, k + 1);
    const Frame frame = measured(**fit, view_of(image, camera.format));
    ASSERT_TRUE(frame.fitted.credible);
    EXPECT_EQ(frame.fitted.lost, 0);
    EXPECT_EQ(frame.allocations, 0U);
    squares += std::pow(error(frame.waves, truth), 2);
    expected += std::pow(error(frame.sigma, Waves(truth.size(), 0.0)), 2);
  }
  std::printf("  %s, %.0f nm, %d modes: error %.5f wave, expected %.5f\n",
              pixel_format_name(camera.format).data(), camera.wavelength_nm, camera.modes,
              std::sqrt(squares / kImages), std::sqrt(expected / kImages));
  EXPECT_LT(squares, 1.3 * 1.3 * expected);
  EXPECT_GT(squares, 0.7 * 0.7 * expected);
}

TEST_P(ColourTemplates, FindTheNoiseOfLitPixels) {
  const Colour camera = GetParam();
  const Waves flat(std::size_t(camera.modes), 0.0);
  const Image<float> electrons = filtered(light(1, flat), camera.lit());
  PointModel model = model_of(camera);
  const auto rendered = model.rendered(flat);
  const auto one = exposed(electrons, kReadNoiseE, 1), other = exposed(electrons, kReadNoiseE, 2);
  const std::vector views{view_of(one, camera.format), view_of(other, camera.format)};
  const PixelNoise of_pair = noise_of(views, rendered), of_one = noise_of(views[0], rendered);
  const double dark_dn2 = kReadNoiseE * kReadNoiseE;
  EXPECT_NEAR(of_pair.per_dn, 1.0, 0.1);
  EXPECT_NEAR(of_pair.constant_dn2, dark_dn2, 0.1 * dark_dn2);
  EXPECT_NEAR(of_one.per_dn, 1.3, 0.2);  // lambda/d is 6.3 pixels of a colour: see noise_of
  EXPECT_NEAR(of_one.constant_dn2, dark_dn2, 0.3 * dark_dn2);
}

/// The bench differs from the model: light that falls off to the rim. The reference takes it up.
TEST_P(ColourTemplates, TakeUpTheBenchOfAReference) {
  const Colour camera = GetParam();
  const Waves truth = random(camera.modes, 0.05, 7), flat(truth.size(), 0.0);
  const auto falling = [&](const Waves& waves) {
    Image<float> image = light(1, waves);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) image.at(x, y) *= 1.0F - 0.001F * float(x - 256);
    }
    return filtered(std::move(image), camera.lit());
  };
  const auto reference = exposed(falling(flat), kReadNoiseE, 1);
  const auto image = exposed(falling(truth), kReadNoiseE, 2);
  PointModel model = model_of(camera);
  const PixelNoise noise{kReadNoiseE * kReadNoiseE, 1.0};
  const auto used = model.use_reference(view_of(reference, camera.format), noise, flat, {});
  ASSERT_TRUE(used) << used.error().reason;
  const auto fit = model.templates(view_of(image, camera.format), std::vector<Waves>{flat}, {}, 12);
  ASSERT_TRUE(fit) << fit.error().reason;
  const Frame frame = measured(**fit, view_of(image, camera.format));
  EXPECT_LT(error(frame.waves, truth), 2.0 * error(frame.sigma, Waves(truth.size(), 0.0)) + 0.001);
}

TEST_P(ColourTemplates, TakeDerivativesFromPixelsOfOneColour) {
  SpotWindow window = window_of(12.0, 2.0, GetParam().lit());
  window.left = 7, window.top = 4;
  Eigen::VectorXf light(window.cells());
  for (Eigen::Index c = 0; c < light.size(); ++c) {
    const auto x = float(c % window.side * window.pitch()),
               y = float(c / window.side * window.pitch());
    light(c) = window.is_lit(c) ? 3.0F * x - y : 1000.0F;
  }
  const Eigen::MatrixXf change = change_by_shift(light, window);
  int lit = 0;
  for (Eigen::Index c = 0; c < light.size(); ++c) {
    if (!window.is_lit(c)) continue;
    ++lit;
    EXPECT_EQ(change(c, 0), -3.0F) << c;
    EXPECT_EQ(change(c, 1), 1.0F) << c;
  }
  EXPECT_GT(4 * lit, window.cells() - 4 * window.side);
}

TEST_P(ColourTemplates, AWindowThatFillsTheImageIsInside) {
  SpotWindow window = window_of(12.0, 2.0, GetParam().lit());
  const int side_px = window.width_px();
  window = moved_to({0.5 * side_px, 0.5 * side_px}, window, side_px, side_px);
  const PixelBox box = window.pixels();
  int last = 0;
  each_pixel(window, [&](Eigen::Index, int x, int y) { last = std::max({last, x, y}); });
  EXPECT_EQ(std::max(box.x + box.width, box.y + box.height), last + 1);
  RenderedSpot spot;
  spot.window = window;
  const MeasuredShapes shapes{.modes_j = {}, .spots = {spot}};
  EXPECT_TRUE(shapes.are_inside(side_px, side_px));
  EXPECT_FALSE(shapes.are_inside(last, last));
}

INSTANTIATE_TEST_SUITE_P(All, ColourTemplates,
                         testing::Values(Colour{PixelFormat::bayer_rg12, 450.0, 18, 0.3},
                                         Colour{PixelFormat::bayer_gr12, 532.0, 18, 0.3},
                                         Colour{PixelFormat::bayer_bg12, 632.8, 18, 0.3},
                                         Colour{PixelFormat::bayer_rg12, 532.0, 44, 0.1},
                                         Colour{PixelFormat::bayer_gb12, 632.8, 44, 0.1}));

}  // namespace
}  // namespace ovws

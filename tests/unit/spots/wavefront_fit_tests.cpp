/// Templates of spots against the wavefront that made the image, and against the noise that they
/// claim.
#include <array>
#include <chrono>
#include <cstdio>
#include <utility>

#include "tests/unit/spots/templates_case.hpp"

namespace ovws {
namespace {

void darken(Image<std::uint16_t>& image, const SpotWindow& window) {
  const PixelBox box = window.pixels();
  for (int y = box.y; y < box.y + box.height; ++y) {
    std::fill_n(&image.at(box.x, y), box.width, std::uint16_t(kBlackDn));
  }
}

TEST_F(Templates, OfAFlatWavefrontAreAsExactAsTheirCovarianceSays) {
  constexpr int kImages = 12;
  const PixelNoise noise{kReadNoiseE * kReadNoiseE, 1.0};
  for (const int charge : {1, 0}) {
    for (const auto& [modes, estimates] :
         {std::pair{18, 2}, {18, 4}, {18, 8}, {27, 8}, {44, 5}, {44, 8}}) {
      const Waves flat(modes, 0.0);
      const auto rendered = renderer(charge, modes).render(flat);
      const Image<float> electrons = light(charge, flat);
      double squares = 0.0, claims = 0.0;
      for (int k = 0; k < kImages; ++k) {
        const auto image = exposed(electrons, kReadNoiseE, unsigned(k) + 1);
        const auto step = step_from(fit_spots(view(image), rendered, noise, estimates));
        ASSERT_TRUE(step);
        squares += std::pow(error(step->waves, flat), 2) / kImages;
        claims += step->covariance.diagonal().tail(modes - 2).sum() / kImages;
      }
      const double measured = std::sqrt(squares), claimed = std::sqrt(claims);
      std::printf("  charge %d, %d modes, %d estimates: error %.5f, claimed %.5f wave\n", charge,
                  modes, estimates, measured, claimed);
      EXPECT_LT(measured, 1.2 * claimed);
      EXPECT_GT(measured, 0.8 * claimed);
    }
  }
}

TEST_F(Templates, TheNoiseIsFoundFromTwoImages) {
  const Waves flat(18, 0.0);
  const auto rendered = renderer(1, 18).render(flat);
  const Image<float> electrons = light(1, flat);
  const auto a = exposed(electrons, kReadNoiseE, 1), b = exposed(electrons, kReadNoiseE, 2);
  const PixelNoise noise = noise_of(std::vector{view(a), view(b)}, rendered);
  EXPECT_NEAR(noise.per_dn, 1.0, 0.1);
  EXPECT_NEAR(noise.constant_dn2, kReadNoiseE * kReadNoiseE, 4.0);
}

/// In a closed loop, or as a bench vibrates, the next image has another wavefront and other light.
TEST_F(Templates, TheNoiseIsFoundWhileTheWavefrontMoves) {
  const Waves flat(18, 0.0), moved = random(18, 0.03, 3);
  const auto rendered = renderer(1, 18).render(flat);
  Image<float> then = light(1, moved);
  for (float& electrons : then.pixels) electrons *= 1.1F;
  const auto a = exposed(then, kReadNoiseE, 1), b = exposed(light(1, flat), kReadNoiseE, 2);
  const PixelNoise noise = noise_of(std::vector{view(a), view(b)}, rendered);
  std::printf("  %.3f DN per DN, %.2f DN^2 in the dark\n", noise.per_dn, noise.constant_dn2);
  EXPECT_NEAR(noise.per_dn, 1.0, 0.3);
  EXPECT_NEAR(noise.constant_dn2, kReadNoiseE * kReadNoiseE, 12.0);
}

/// Where the squares grow faster than the intensity, as from fringes, a straight line would be
/// below zero at the dark end.
TEST_F(Templates, TheNoiseOfDarkCellsIsNeverNegligible) {
  const auto rendered = renderer(1, 18).render(Waves(18, 0.0));
  Image<float> electrons = light(1, Waves(18, 0.0));
  for (int y = 0; y < electrons.height; ++y) {
    for (int x = 0; x < electrons.width; ++x) {
      float& pixel = electrons.at(x, y);
      pixel += ((x + y) % 2 == 0 ? 1e-3F : -1e-3F) * pixel * pixel;
    }
  }
  const auto image = exposed(electrons, 0.1, 1);
  const PixelNoise noise = noise_of(view(image), rendered);
  std::printf("  %.3f DN per DN, %.3f DN^2 in the dark\n", noise.per_dn, noise.constant_dn2);
  EXPECT_GT(noise.constant_dn2, 0.1 * noise.per_dn);
}

/// Templates about what the tracker knows, as in the daemon.
TEST_F(Templates, FindTheWavefrontFromARoughStart) {
  const Waves flat(18, 0.0);
  const auto reference = exposed(light(1, flat, 2000.0), kReadNoiseE, 9);
  PointModel points(renderer(1, 18), 8);
  ASSERT_TRUE(points.use_reference(view(reference), {25.0, 1.0}, random(18, 0.02, 7), {}));
  for (const double rms : {0.1, 0.3, 0.6, 0.9}) {
    const Waves truth = random(18, rms, 5), off = random(18, 0.04, 6);
    Waves start = truth;
    for (std::size_t k = 0; k < start.size(); ++k) start[k] += off[k];
    const Image<float> electrons = light(1, truth, 2000.0);
    const auto image = exposed(electrons, kReadNoiseE, 1),
               other = exposed(electrons, kReadNoiseE, 2);
    const auto fit =
        points.templates(std::vector{view(other), view(image)}, std::vector<Waves>{start}, {}, 4);
    ASSERT_TRUE(fit) << rms << " wave: " << fit.error().reason;
    const Frame frame = measured(**fit, view(image));
    double claimed = 0.0;
    for (std::size_t k = 2; k < 18; ++k) claimed += double(frame.sigma[k] * frame.sigma[k]);
    std::printf("  %.1f wave: error %.5f, claimed %.5f wave, drift %.4f, residual %.2f, %d lost\n",
                rms, error(frame.waves, truth), std::sqrt(claimed), frame.fitted.drift_waves,
                frame.fitted.residual, frame.fitted.lost);
    EXPECT_TRUE(frame.fitted.credible);
    EXPECT_EQ(frame.fitted.lost, 0);
    EXPECT_EQ(frame.allocations, 0U);
    EXPECT_LT(error(frame.waves, truth), 0.003);
  }
}

struct Distance {
  int charge, modes;
  double rms;  ///< of the operating point, waves
};

/// Away from the operating point, errors grow faster the more modes there are and the stronger the
/// wavefront is. The standard errors allow for it, and far frames are not credible.
class AwayFromTheirPoint : public Templates, public testing::WithParamInterface<Distance> {};

TEST_P(AwayFromTheirPoint, TemplatesKnowTheirError) {
  const auto [charge, modes, rms] = GetParam();
  const PixelNoise noise{kReadNoiseE * kReadNoiseE, 1.0};
  PointModel model(renderer(charge, modes), kMaxSpotEstimates);
  int credible = 0;
  double worst = 0.0, squares = 0.0, claims = 0.0;
  for (unsigned draw = 1; draw <= 3; ++draw) {
    const Waves point = random(modes, rms, draw), step = random(modes, 1.0, draw + 100);
    const auto image = exposed(light(charge, point), kReadNoiseE, draw);
    const std::vector<Waves> start{point};
    const auto fit = model.templates(view(image), noise, start, {}, 8);
    ASSERT_TRUE(fit) << fit.error().reason;
    for (const double away : {-0.15, -0.1, -0.03, 0.03, 0.1, 0.15}) {
      Waves truth = point;
      for (std::size_t k = 0; k < truth.size(); ++k) truth[k] += away * step[k];
      const auto moved = exposed(light(charge, truth), kReadNoiseE, draw);
      const Frame frame = measured(**fit, view(moved));
      EXPECT_TRUE(frame.fitted.credible || std::abs(away) > 0.03) << away << ", draw " << draw;
      if (!frame.fitted.credible) continue;
      ++credible;
      worst = std::max(worst, error(frame.waves, truth));
      squares += std::pow(error(frame.waves, truth), 2);
      for (std::size_t k = 2; k < truth.size(); ++k) claims += std::pow(double(frame.sigma[k]), 2);
    }
  }
  std::printf("  %d of 18 credible, error %.3f, claimed %.3f, worst %.3f wave\n", credible,
              std::sqrt(squares / credible), std::sqrt(claims / credible), worst);
  EXPECT_LT(worst, 0.08);
  EXPECT_LT(squares, 2.0 * claims);
  EXPECT_GT(9.0 * squares, claims) << "the standard errors are too large";
}

INSTANTIATE_TEST_SUITE_P(Templates, AwayFromTheirPoint,
                         testing::Values(Distance{1, 9, 0.3}, Distance{1, 18, 0.3},
                                         Distance{0, 18, 0.3}, Distance{1, 18, 0.9},
                                         Distance{1, 44, 0.3}, Distance{1, 44, 0.6}));

/// Searches a wavefront from a flat start, as the daemon does: in two images, and if that fails, in
/// two others with more renderings. Whether it was found; never a wrong one. Adds the time that the
/// searches took to `took_ms`.
bool search(PointModel& points, const Image<float>& electrons, const Waves& truth,
            double read_noise_e, double black_dn, double& took_ms) {
  const std::vector<Waves> flat{Waves(truth.size(), 0.0)};
  for (const auto& [seed, renderings] : {std::pair{1U, 12}, {3U, 40}}) {
    const auto other = Templates::exposed(electrons, read_noise_e, seed + 1, black_dn);
    const auto image = Templates::exposed(electrons, read_noise_e, seed, black_dn);
    const auto begun = std::chrono::steady_clock::now();
    const auto fit = points.templates(std::vector{Templates::view(other), Templates::view(image)},
                                      flat, {}, renderings);
    took_ms +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
    if (!fit) continue;
    const auto frame = Templates::measured(**fit, Templates::view(image));
    EXPECT_LT(Templates::error(frame.waves, truth), 0.01);
    return true;
  }
  return false;
}

TEST_F(Templates, FindStrongWavefrontsFromAFlatStart) {
  struct Case {
    int charge, modes;
    double rms, read_noise_e;
    int draws, least_found;
  };
  for (const Case& one :
       {Case{1, 18, 0.5, kReadNoiseE, 20, 20}, Case{1, 18, 0.8, 20.0, 24, 24},
        Case{0, 18, 0.8, kReadNoiseE, 12, 11}, Case{1, 44, 0.4, kReadNoiseE, 12, 9}}) {
    const PixelNoise noise{one.read_noise_e * one.read_noise_e + 1.0 / 12.0, 1.0};
    const double black_dn = std::max(kBlackDn, 4.0 * one.read_noise_e);
    const Waves flat(std::size_t(one.modes), 0.0);
    PointModel points(renderer(one.charge, one.modes, 0.0), 8);
    const auto reference = exposed(light(one.charge, flat, 2000.0), one.read_noise_e, 9, black_dn);
    ASSERT_TRUE(points.use_reference(view(reference), noise, flat, {}));
    int found = 0;
    std::vector<double> all_ms(std::size_t(one.draws));
    for (int draw = 0; draw < one.draws; ++draw) {
      const Waves truth = random(one.modes, one.rms, unsigned(100 + draw));
      const Image<float> electrons = light(one.charge, truth, 2000.0);
      double& took_ms = all_ms[std::size_t(draw)];
      found += search(points, electrons, truth, one.read_noise_e, black_dn, took_ms) ? 1 : 0;
    }
    std::ranges::sort(all_ms);
    std::printf(
        "  charge %d, %d modes, %.1f wave: %d of %d found, in %.0f ms (median), %.0f at most\n",
        one.charge, one.modes, one.rms, found, one.draws, all_ms[all_ms.size() / 2], all_ms.back());
    EXPECT_GE(found, one.least_found);
  }
}

/// Images in which twelve steps end half-way, where 44 modes leave no more than the noise.
TEST_F(Templates, OfDimLightAreRefusedHalfWay) {
  const Waves flat(44, 0.0);
  PointModel points(renderer(1, 44, 0.0), 8);
  for (const auto& [rms, seed] : {std::pair(0.4, 13U), {0.6, 17U}, {0.6, 29U}}) {
    const Waves truth = random(44, rms, seed);
    const auto image = exposed(light(1, truth, 100.0), kReadNoiseE, seed);
    const auto fit = points.templates(view(image), {kReadNoiseE * kReadNoiseE + 1.0 / 12.0, 1.0},
                                      std::vector<Waves>{flat}, {}, 12);
    EXPECT_TRUE(!fit || error(measured(**fit, view(image)).waves, truth) < 0.05) << seed;
  }
}

TEST_F(Templates, OfASingleImageNeedNoReference) {
  const Waves flat(18, 0.0), truth = random(18, 0.1, 1);
  const auto image = exposed(light(1, truth, 2000.0), kReadNoiseE, 1);
  PointModel points(renderer(1, 18), 8);
  const auto fit = points.templates(std::vector{view(image)}, std::vector<Waves>{flat}, {}, 12);
  ASSERT_TRUE(fit) << fit.error().reason;
  EXPECT_LT(error(measured(**fit, view(image)).waves, truth), 0.01);
}

/// The noise of three frames, between which the light changed twice. If it counted, every later
/// search would be refused, because the reference seems to be explained better than by noise alone.
TEST_F(Templates, DoNotBelieveMoreNoiseThanTheReferenceShows) {
  const Waves flat(18, 0.0), truth = random(18, 0.1, 1);
  const auto image = exposed(light(1, flat), kReadNoiseE, 1);
  const Image<float> dark(kImagePx, kImagePx);
  const std::vector frames{image, exposed(light(1, truth, 1e4), kReadNoiseE, 2),
                           exposed(dark, kReadNoiseE, 3)};
  const auto changed = exposed(light(1, truth), kReadNoiseE, 4);
  PointModel points(renderer(1, 18), 8);
  const auto noise = noise_of(std::vector{view(frames[0]), view(frames[1]), view(frames[2])},
                              points.rendered(flat));
  for (const PixelNoise& claimed : {noise, PixelNoise{25.0, 1.0}, PixelNoise{1e6, 0.0}}) {
    ASSERT_TRUE(points.use_reference(view(image), claimed, flat, {}));
    const auto fit = points.templates(std::vector{view(changed)}, std::vector<Waves>{flat}, {}, 12);
    ASSERT_TRUE(fit) << fit.error().reason;
    EXPECT_LT(error(measured(**fit, view(changed)).waves, truth), 0.02);
  }
}

TEST_F(Templates, DoNotDescribeAnotherWavefront) {
  const Waves flat(18, 0.0);
  const auto image = exposed(light(1, flat), kReadNoiseE, 1);
  PointModel points(renderer(1, 18), 8);
  ASSERT_TRUE(points.use_reference(view(image), {25.0, 1.0}, flat, {}));
  const auto other = exposed(light(1, flat), kReadNoiseE, 2);
  const auto fit =
      points.templates(std::vector{view(other), view(image)}, std::vector<Waves>{flat}, {}, 4);
  ASSERT_TRUE(fit) << fit.error().reason;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Waves truth = random(18, 0.5, seed);
    const auto changed = exposed(light(1, truth), kReadNoiseE, seed);
    const Frame frame = measured(**fit, view(changed));
    EXPECT_FALSE(frame.fitted.credible) << "seed " << seed;
    EXPECT_EQ(frame.allocations, 0U);
  }
}

/// Nine spots are dark: a far step is damped as by the ten others alone.
TEST_F(Templates, OfSpotsThatAreNotFoundDoNotWeakenTheDamping) {
  const auto rendered = renderer(1, 18).render(Waves(18, 0.0));
  auto image = exposed(light(1, random(18, 0.3, 4), 2000.0), kReadNoiseE, 1);
  for (std::size_t i = 0; i < 9; ++i) darken(image, rendered[i].window);
  const SpotPass pass = fit_spots(view(image), rendered, {kReadNoiseE * kReadNoiseE, 1.0}, 8);
  SpotPass bright = pass;
  bright.found.clear(), bright.templates.clear();
  for (std::size_t i = 0; i < pass.found.size(); ++i) {
    if (!(pass.found[i].level > 0.0F)) continue;
    bright.found.push_back(pass.found[i]);
    bright.templates.push_back(pass.templates[i]);
  }
  ASSERT_EQ(bright.found.size(), 10U);
  const auto step = damped_step(pass), of_bright = damped_step(bright);
  ASSERT_TRUE(step && of_bright);
  std::printf("  step of %.4f wave, of the spots found alone %.4f\n", step->waves.norm(),
              of_bright->waves.norm());
  EXPECT_NEAR((step->waves - of_bright->waves).norm(), 0.0, 1e-9);
}

/// Most spots are beyond the image's edge: the background is that of the others.
TEST_F(Templates, ForWhichNoSpotIsRenderedDoNotRaiseTheCeiling) {
  constexpr double kUsedShare = 0.9, kFullDn = 65535.0;
  auto rendered = renderer(1, 18).render(Waves(18, 0.0));
  for (std::size_t i = 0; i < 12; ++i) rendered[i].light.setZero();
  const auto image = exposed(light(1, Waves(18, 0.0)), kReadNoiseE, 1, 5000.0);
  const SpotPass pass = fit_spots(view(image), rendered, {kReadNoiseE * kReadNoiseE, 1.0}, 8);
  EXPECT_NEAR(pass.ceiling_dn, kUsedShare * kFullDn - 5000.0, 10.0);
}

/// In bright light, too: another wavefront may agree with 16 spots of 19.
TEST_F(Templates, AreNotConfirmedByAFrameWithoutThreeSpotsOfNineteen) {
  const Waves flat(18, 0.0);
  const auto reference = exposed(light(1, flat, 2000.0), kReadNoiseE, 1);
  PointModel points(renderer(1, 18), 8);
  ASSERT_TRUE(points.use_reference(view(reference), {25.0, 1.0}, flat, {}));
  auto image = exposed(light(1, flat, 2000.0), kReadNoiseE, 2);
  const auto fit =
      points.templates(std::vector{view(reference), view(image)}, std::vector<Waves>{flat}, {}, 4);
  ASSERT_TRUE(fit) << fit.error().reason;
  for (int lost = 1; lost <= 3; ++lost) {
    darken(image, (*fit)->spots().spots()[std::size_t(lost)].window);
    const auto again = points.templates(std::vector{view(reference), view(image)},
                                        std::vector<Waves>{flat}, {}, 4);
    EXPECT_EQ(again.has_value(), lost <= 2) << lost << " spots lost";
  }
}

}  // namespace
}  // namespace ovws

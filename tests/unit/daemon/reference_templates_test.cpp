/// Own templates (from the reference's image) or the model's: the report, and the plan that
/// results.
#include "daemon/ovwsd/sensor/reference_templates.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/tracking/spot_shape.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {
namespace {

const TrackingSettings kAsked{{TrackerKind::matched, 0.3}, TemplateKind::reference};
const std::vector<Vec2> kAt{{80.25, 80.5}, {240.0, 79.75}};

/// An image of the model's spots.
Reference reference_of(const SpotModel& spots) {
  const ModelShape shape(spots, 5.0);
  auto picture = std::make_shared<ReferencePicture>();
  picture->frames = 8;
  picture->mean_dn = Image<float>(320, 160);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 320; ++x) {
      for (const Vec2 at : kAt) {
        picture->mean_dn.at(x, y) += float(100.0 * shape.at(Vec2{double(x), double(y)} - at).value);
      }
    }
  }
  Reference reference;
  reference.positions_px = kAt;
  reference.picture = picture;
  return reference;
}

TEST(OwnTemplates, AreMadeOfThePicture) {
  const SpotModel spots;
  const Reference reference = reference_of(spots);
  const OwnTemplates own = own_templates(kAsked, spots, &reference);
  EXPECT_EQ(own.report.own, 2);
  EXPECT_EQ(own.report.reason, "");
  ASSERT_EQ(own.banks.size(), 2U);
  EXPECT_TRUE(own.banks[0] && own.banks[1]);
}

TEST(OwnTemplates, OfASaturatedSpotAreTheModelsAndItIsSaid) {
  const SpotModel spots;
  Reference reference = reference_of(spots);
  ReferencePicture spoilt = *reference.picture;
  spoilt.mean_dn.at(244, 76) = NAN;
  reference.picture = std::make_shared<ReferencePicture>(spoilt);
  const OwnTemplates own = own_templates(kAsked, spots, &reference);
  EXPECT_EQ(own.report.own, 1);
  ASSERT_EQ(own.banks.size(), 2U);
  EXPECT_TRUE(own.banks[0]);
  EXPECT_FALSE(own.banks[1]);
  EXPECT_NE(own.report.reason.find("spots 1 is"), std::string::npos) << own.report.reason;
}

TEST(OwnTemplates, SayWhyThereAreNone) {
  const SpotModel spots;
  Reference reference = reference_of(spots);
  const auto reason = [&](const TrackingSettings& tracking, const Reference* from) {
    const OwnTemplates own = own_templates(tracking, spots, from);
    EXPECT_TRUE(own.banks.empty());
    EXPECT_EQ(own.report.own, 0);
    return own.report.reason;
  };
  EXPECT_EQ(reason({{TrackerKind::matched, 0.3}, TemplateKind::model}, &reference), "");
  EXPECT_NE(reason({{TrackerKind::lg, 0.3}, TemplateKind::reference}, &reference).find("matched"),
            std::string::npos);
  EXPECT_NE(reason(kAsked, nullptr).find("take one"), std::string::npos);
  reference.picture.reset();
  EXPECT_NE(reason(kAsked, &reference).find("no mean image"), std::string::npos);
}

TEST(OwnTemplates, AreNotMadeOfAPictureThroughOtherFilters) {
  const LitPixels red = lit_pixels(PixelFormat::bayer_rg12, 632.0);
  Reference reference = reference_of({});
  auto picture = std::make_shared<ReferencePicture>(*reference.picture);
  picture->format = PixelFormat::bayer_rg12;
  reference.picture = picture;
  const OwnTemplates plain = own_templates(kAsked, {}, &reference);
  EXPECT_TRUE(plain.banks.empty());
  EXPECT_NE(plain.report.reason.find("BayerRG12"), std::string::npos);
  EXPECT_FALSE(own_templates(kAsked, {1, 12.55, red}, &reference).banks.empty());
  picture->format = PixelFormat::bayer_gr12;  // other pixels are red
  EXPECT_TRUE(own_templates(kAsked, {1, 12.55, red}, &reference).banks.empty());
  picture->format = PixelFormat::mono12;  // all pixels have light
  EXPECT_FALSE(own_templates(kAsked, {1, 12.55, red}, &reference).banks.empty());
}

TEST(OwnTemplates, ThatAreTooLargeAreNotMade) {
  Reference reference = reference_of({});
  reference.positions_px.resize(703);
  const OwnTemplates own = own_templates(kAsked, {1, 77.8}, &reference);
  EXPECT_EQ(own.report.own, 0);
  EXPECT_NE(own.report.reason.find("MiB"), std::string::npos);
}

TEST(TemplateCache, KeepsThoseOfThePictureInUse) {
  const SpotModel spots;
  const Reference reference = reference_of(spots);
  TemplateCache cache;
  const auto first = cache.of(kAsked, spots, &reference).banks;
  EXPECT_EQ(cache.of(kAsked, spots, &reference).banks, first);
  EXPECT_TRUE(cache.of(kAsked, spots, nullptr).banks.empty());
  EXPECT_NE(cache.of(kAsked, spots, &reference).banks, first);
}

TEST(ReferenceKey, HoldsTheTemplateOfATrackerThatHasOne) {
  TrackingSettings lg = kAsked;
  lg.tracker = TrackerKind::lg;
  EXPECT_EQ(reference_key({}, lg, {}), reference_key({}, {{TrackerKind::lg}}, {}));
  EXPECT_EQ(reference_key({}, kAsked, {}).tracking, kAsked);
}

TEST(ReferenceKey, IsTheSameForTrackersThatFindTheSamePositions) {
  TrackingSettings fit;
  fit.mode_count = 44;
  EXPECT_EQ(reference_key({}, fit, {}), reference_key({}, {{TrackerKind::lg}}, {}));
  EXPECT_NE(reference_key({}, fit, {}), reference_key({}, {{TrackerKind::matched}}, {}));
}

TEST(BuildPlan, GivesTheTemplatesToTheTrackerThatTakesThem) {
  const SensorConfig sensor;
  const OpticsConfig optics;
  const SlmGeometry slm;
  const Roi roi{0, 0, 512, 512};
  const auto lattice = make_lattice(sensor, slm);
  ASSERT_TRUE(lattice);
  const std::vector<Mode> none;
  const SpotModel spots;
  const Reference reference = reference_of(spots);
  const auto own = own_templates(kAsked, spots, &reference).banks;
  const auto per_spot = [&](const TrackingSettings& tracking, const auto& templates) {
    const auto plan = build_plan({1,
                                  1,
                                  1,
                                  *lattice,
                                  sensor,
                                  tracking,
                                  optics,
                                  slm,
                                  roi,
                                  PixelFormat::mono8,
                                  {},
                                  none,
                                  nullptr,
                                  templates});
    EXPECT_TRUE(plan);
    return (*plan)->tracker->per_spot();
  };
  EXPECT_TRUE(per_spot(kAsked, own));
  EXPECT_FALSE(per_spot(kAsked, decltype(own){}));
  EXPECT_FALSE(per_spot({TrackerKind::lg, 0.3}, own));
}

}  // namespace
}  // namespace ovws

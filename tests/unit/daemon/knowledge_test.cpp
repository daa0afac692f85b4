#include "daemon/ovwsd/sensor/knowledge.hpp"

#include <gtest/gtest.h>

#include "core/optics/lattice.hpp"

namespace ovws {
namespace {

/// A small bench, its sensor, and references of it.
class Known : public testing::Test {
 protected:
  Known() {
    config_.slm.geometry = {160, 96, 19.0};
    config_.sensor.pupil_diameter_px = 96.0;
    config_.sensor.subapertures_across = 3;
    config_.sensor.grooves = {20.0, 4.0};
    config_.sensor.spacing = 0.25;
    optics_ = {config_.optics, config_.slm.geometry};
    hologram_.slm = config_.slm.geometry;
    hologram_.sensor = config_.sensor;
    state_.sensor = config_.sensor;
    state_.tracking = config_.tracking;
    state_.roi = {0, 0, 256, 256};
    state_.slm = driven({});
    EXPECT_TRUE(renew_renderer(state_));
  }

  std::shared_ptr<const ActiveSlm> driven(const PhaseLut& lut) const {
    auto slm = std::make_shared<ActiveSlm>();
    slm->hologram = hologram_;
    slm->hologram.lut = lut;
    slm->identity = slm_identity(slm->hologram, true);
    return slm;
  }

  Reference taken(std::int64_t t_taken_ns, const std::optional<CameraInfo>& camera = std::nullopt) {
    Reference reference;
    Knowledge known;
    known.camera = camera;
    reference.key = key_of(state_, known, optics_);
    reference.t_taken_ns = t_taken_ns;
    reference.registration = registration_of(state_, optics_);
    reference.positions_px = model_positions(state_, optics_);
    return reference;
  }
  /// Makes it the reference of this state, and returns those that it replaces.
  Shared<Reference> replace(Reference reference) {
    auto replaced = remove_items<Reference>(known_, state_, optics_);
    add_items<Reference>(known_, {std::make_shared<const Reference>(std::move(reference))});
    return replaced;
  }

  std::shared_ptr<const Reference> found() const { return bind(state_, known_, optics_).reference; }
  std::string why_not(const Reference& reference) const {
    return unused_reason(reference, state_, known_, optics_, false);
  }

  Config config_;
  BenchOptics optics_;
  HologramConfig hologram_;
  SensorState state_;
  Knowledge known_;
};

const CameraInfo kOne{"Ovws", "Twin", "1", ""}, kTwo{"Ovws", "Twin", "2", ""};

TEST_F(Known, TheReferenceTakenLastIsBound) {
  EXPECT_FALSE(found());
  EXPECT_TRUE(replace(taken(5)).empty());
  const auto replaced = replace(taken(6));
  ASSERT_EQ(replaced.size(), 1U);
  EXPECT_EQ(replaced[0]->t_taken_ns, 5);
  EXPECT_EQ(found()->t_taken_ns, 6);
  EXPECT_EQ(remove_items<Reference>(known_, state_, optics_).size(), 1U);
  EXPECT_FALSE(found());
}

TEST_F(Known, AReferenceIsOfItsSensorTrackingAndRegion) {
  replace(taken(5));
  const SensorState before = state_;
  state_.sensor.charge = 2;
  EXPECT_FALSE(found());
  EXPECT_EQ(why_not(*known_.references[0]), "") << "it is another sensor's";
  EXPECT_EQ(missing_reference_reason(state_, known_, optics_), "");
  state_ = before;
  state_.roi.x = 16;
  EXPECT_FALSE(found());
  EXPECT_EQ(why_not(*known_.references[0]), "camera.roi.x was 0, and is 16");
  EXPECT_EQ(
      missing_reference_reason(state_, known_, optics_),
      "the reference of 1970-01-01T00:00:00.000Z is not used: " + why_not(*known_.references[0]));
  state_.tracking.tracker = TrackerKind::centroid;
  EXPECT_EQ(why_not(*known_.references[0]), "") << "it is another tracker's";
  state_ = before;
  state_.tracking.mode_operator = OperatorKind::measured;
  EXPECT_TRUE(found()) << "no position depends on it";
}

TEST_F(Known, NoMoreReferencesAreKeptThanOnTheDisk) {
  for (int k = 0; k <= int(kReferenceItems.most); ++k) {
    state_.roi.x = 16 * k;
    replace(taken(k));
  }
  EXPECT_EQ(known_.references.size(), kReferenceItems.most);
  EXPECT_EQ(known_.references[0]->t_taken_ns, 1);
}

TEST_F(Known, AReferenceOfAnArrayThatWasFoundElsewhereSaysSo) {
  state_.sensor.lenslets.centres_px = {{10.0, 10.0}, {30.0, 10.0}};
  const SensorState before = state_;
  state_.sensor.lenslets.centres_px.clear();  // no position is needed
  Reference reference = taken(5);
  reference.key.sensor = before.sensor;
  reference.source = ReferenceSource::model;  // of any registration
  known_.references.push_back(std::make_shared<const Reference>(reference));
  state_ = before;
  EXPECT_EQ(why_not(reference).find("the array has not been found yet"), 0U);
  EXPECT_FALSE(found());
  state_.registration.emplace();
  EXPECT_EQ(why_not(reference), "");
  state_.sensor.lenslets.centres_px[1].x = 31.0;
  state_.sensor.subapertures_across = 5;
  EXPECT_EQ(why_not(reference), "the lenslets have been measured elsewhere since it was taken");
}

TEST_F(Known, AReferenceOfAnotherCameraIsNotBoundAndOneOfAnUnknownIs) {
  replace(taken(5, kOne));
  EXPECT_TRUE(found());
  known_.camera = kOne;
  EXPECT_TRUE(found());
  known_.camera = kTwo;
  EXPECT_FALSE(found());
  EXPECT_EQ(why_not(*known_.references[0]), "camera.serial was \"1\", and is \"2\"");
  EXPECT_TRUE(replace(taken(6, kTwo)).empty()) << "the other one stays";
  EXPECT_EQ(found()->t_taken_ns, 6);
  known_.camera = kOne;
  EXPECT_EQ(found()->t_taken_ns, 5);
}

TEST_F(Known, AReferenceIsOfTheLutThatDroveTheSlm) {
  replace(taken(5));
  PhaseLut other{};
  other[200] = 7;
  const auto before = state_.slm;
  state_.slm = driven(other);
  EXPECT_FALSE(found());
  EXPECT_EQ(why_not(*known_.references[0]).find("it was taken with another look-up table"), 0U);
  state_.slm = before;
  EXPECT_TRUE(found());
}

TEST_F(Known, AReferenceIsNotBoundWhereSpotsAreExpectedElsewhere) {
  replace(taken(5));
  MeasuredRegistration map;
  const auto as_configured = px_per_cycle(optics_.optics, optics_.slm);
  map.px_per_cycle = as_configured;
  map.base_px = base_spot_px(optics_of(state_, optics_), state_.roi.width, state_.roi.height);
  map.base_cpp = base_grating_cpp(state_.sensor, optics_.slm);
  state_.registration = map;
  EXPECT_TRUE(found()) << "the same places";
  state_.registration->base_px = map.base_px + Vec2{lambda_d_of(state_, optics_), 0.0};
  EXPECT_FALSE(found());
  EXPECT_EQ(why_not(*known_.references[0]).find("the expected spot positions have changed"), 0U);
}

TEST_F(Known, AModelReferenceFollowsTheRegistration) {
  Reference model = taken(5);
  model.source = ReferenceSource::model;
  replace(std::move(model));
  MeasuredRegistration map;
  map.px_per_cycle = px_per_cycle(optics_.optics, optics_.slm);
  map.base_px = {100.0, 90.0};
  map.base_cpp = base_grating_cpp(state_.sensor, optics_.slm);
  state_.registration = map;
  ASSERT_TRUE(found());
  EXPECT_EQ(found()->positions_px, model_positions(state_, optics_));
  EXPECT_NE(found()->positions_px, known_.references[0]->positions_px);
}

TEST_F(Known, OnlyTheLastReferencesKeepTheirImages) {
  for (int n = 0; n < 12; ++n) {
    state_.roi.x = n;
    Reference reference = taken(n);
    reference.picture = std::make_shared<const ReferenceImage>();
    replace(std::move(reference));
  }
  ASSERT_EQ(known_.references.size(), 12U);
  EXPECT_FALSE(known_.references[3]->picture);
  EXPECT_TRUE(known_.references[4]->picture);
}

TEST_F(Known, ACopyIsNotChangedByAChange) {
  replace(taken(5));
  Knowledge copy = known_;
  remove_items<Reference>(copy, state_, optics_);
  EXPECT_TRUE(found());
}

TEST_F(Known, WhatIsShownIsTheAberrationLessTheCorrection) {
  state_.aberration = {{3, 0.5}, {4, 0.1}};
  state_.correction = {{3, 0.2}, {5, 0.3}};
  EXPECT_EQ(shown_modes(state_), (std::vector<Mode>{{3, 0.3}, {4, 0.1}, {5, -0.3}}));
  EXPECT_EQ(shown_epoch(state_), state_.sensor_epoch);
  state_.pattern = HologramKind::grating;
  EXPECT_EQ(shown_modes(state_), (std::vector<Mode>{{3, -0.2}, {5, -0.3}}));
  EXPECT_EQ(shown_epoch(state_), 0U) << "there is nothing to measure";
}

}  // namespace
}  // namespace ovws

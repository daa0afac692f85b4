/// Plans that a replay rebuilds from a recording: each field equals that of the live plan.
#include "daemon/ovwsd/record/recorded_plan.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <tuple>
#include <typeinfo>

#include "core/spots/spot_renderer.hpp"
#include "daemon/ovwsd/record/plan_facts.hpp"
#include "daemon/ovwsd/sensor/plans.hpp"
#include "daemon/shared/encoding.hpp"
#include "drivers/record/record_file.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws {
namespace {

constexpr int kSize = test::SpotBench::kSize;

/// All fields of a plan. A field that is added to MeasurementPlan makes this list of names too
/// short, which does not compile: add it, and what a recording needs to rebuild it.
auto fields_of(const MeasurementPlan& plan) {
  const auto& [id, sensor_epoch, hologram_id, correction, charge, tracker_kind, mode_operator,
               spots, roi, format, predicted_px, reference_px, introduced_rms, awaits_templates,
               can_fit_shapes, tracker, kinds, modes_j, reconstructor, branch_points, fit, beam,
               region, beams, patterns, cycle] = plan;
  return std::tie(id, sensor_epoch, hologram_id, correction, charge, tracker_kind, mode_operator,
                  spots, roi, format, predicted_px, reference_px, introduced_rms, awaits_templates,
                  can_fit_shapes, tracker, kinds, modes_j, reconstructor, branch_points, fit, beam,
                  region, beams, patterns, cycle);
}

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0 || (std::isnan(a) && std::isnan(b));
}

/// Compares the fields of two plans: numbers exactly, and what computes by the numbers it gives.
class Comparison {
 public:
  Comparison() : picture_(test::SpotBench::draw_vortices(test::SpotBench().model_px)) {}

  void expect_same(const MeasurementPlan& live, const MeasurementPlan& rebuilt) const {
    expect_same_fields(fields_of(live), fields_of(rebuilt),
                       std::make_index_sequence<std::tuple_size_v<decltype(fields_of(live))>>());
  }

 private:
  template <class Fields, std::size_t... I>
  void expect_same_fields(const Fields& live, const Fields& rebuilt,
                          std::index_sequence<I...>) const {
    (expect_same_field(I, std::get<I>(live), std::get<I>(rebuilt)), ...);
  }
  template <class T>
  void expect_same_field(std::size_t number, const T& live, const T& rebuilt) const {
    EXPECT_TRUE(same(live, rebuilt)) << "field " << number << " of fields_of";
  }

  /// Pointers of other types than those below are the same object only, so this fails for them.
  template <class T>
  bool same(const T& a, const T& b) const {
    return a == b;
  }
  bool same(const double& a, const double& b) const { return same_bits(a, b); }
  bool same(const std::vector<Vec2>& a, const std::vector<Vec2>& b) const {
    return std::ranges::equal(
        a, b, [](Vec2 p, Vec2 q) { return same_bits(p.x, q.x) && same_bits(p.y, q.y); });
  }
  bool same(const std::vector<Mode>& a, const std::vector<Mode>& b) const {
    return std::ranges::equal(
        a, b, [](Mode p, Mode q) { return p.j == q.j && same_bits(p.waves, q.waves); });
  }
  bool same(const std::optional<Disc>& a, const std::optional<Disc>& b) const {
    return a.has_value() == b.has_value() &&
           (!a || (a->centre == b->centre && same_bits(a->radius, b->radius)));
  }
  template <class T>
  bool same(const std::shared_ptr<const T>& a, const std::shared_ptr<const T>& b) const {
    return (a == nullptr) == (b == nullptr) && (a == nullptr || alike(*a, *b));
  }
  bool same(const std::vector<std::shared_ptr<const MeasurementPlan>>& a,
            const std::vector<std::shared_ptr<const MeasurementPlan>>& b) const {
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) expect_same(*a[k], *b[k]);
    return a.size() == b.size();
  }

  ImageView image() const { return view_of(*picture_); }
  bool alike(const SpotTracker& a, const SpotTracker& b) const {
    TrackScratch scratch = a.make_scratch(), other = b.make_scratch();
    for (const Vec2 at : test::SpotBench().model_px) {
      const SpotFix one = a.track(image(), at + Vec2{2.0, -1.0}, scratch);
      const SpotFix two = b.track(image(), at + Vec2{2.0, -1.0}, other);
      if (!same_bits(one.x, two.x) || !same_bits(one.quality, two.quality)) return false;
    }
    return typeid(a) == typeid(b);
  }
  bool alike(const SpotKinds& a, const SpotKinds& b) const {
    bool are = a.of_spots() == b.of_spots() && a.count() == b.count();
    for (int k = 0; are && k < a.count(); ++k) {
      are = a.model(k) == b.model(k) && alike(a.tracker(k), b.tracker(k));
    }
    return are;
  }
  bool alike(const Reconstructor& a, const Reconstructor& b) const {
    std::vector<SpotFix> spots(std::size_t(a.slopes().rows() / 2));
    for (std::size_t i = 0; i < spots.size(); ++i) {
      spots[i].x = float(17 * i % 31);
      spots[i].y = float(11 * i % 23);
    }
    std::vector<float> one(a.modes_j().size()), two(b.modes_j().size());
    auto scratch = a.make_scratch(), other = b.make_scratch();
    (void)a.solve(spots, scratch, one);
    (void)b.solve(spots, other, two);
    return a.modes_j() == b.modes_j() && a.slopes() == b.slopes() && a.nuisance() == b.nuisance() &&
           std::ranges::equal(one, two, [](double p, double q) { return same_bits(p, q); });
  }
  /// By the branch points that both find in displacements about three places.
  bool alike(const BranchPoints& a, const BranchPoints& b) const {
    const test::SpotBench bench;
    int found = 0;
    for (const Vec2 centre : {Vec2{250.0, 260.0}, Vec2{310.0, 200.0}, Vec2{200.0, 300.0}}) {
      std::vector<Vec2> left;
      for (const Vec2 at : bench.model_px) {
        const Vec2 r = at - centre;
        left.push_back(400.0 / (r.x * r.x + r.y * r.y) * Vec2{-r.y, r.x});
      }
      std::array<BranchPoint, kMaxBranchPoints> one{}, two{};
      const int count = a.find(left, -1, one);
      if (b.find(left, -1, two) != count) return false;
      for (std::size_t k = 0; k < std::size_t(count); ++k) {
        if (!(one[k].at == two[k].at) || one[k].charge != two[k].charge) return false;
      }
      found += count;
    }
    EXPECT_GT(found, 0) << "the displacements contain no branch point";
    return true;
  }
  bool alike(const FrameFit& a, const FrameFit& b) const {
    const FrameFit::Measured one = a.measure(image()), two = b.measure(image());
    return a.modes_j() == b.modes_j() && a.point().waves == b.point().waves &&
           std::ranges::equal(one.coefficients, two.coefficients,
                              [](double p, double q) { return same_bits(p, q); });
  }

  std::shared_ptr<const Image<std::uint8_t>> picture_;
};

class RecordedPlan : public testing::Test {
 protected:
  RecordedPlan() {
    auto slm = std::make_shared<ActiveSlm>();
    slm->hologram.slm = rig_.bench.slm;
    state_.sensor = rig_.bench.sensor;
    state_.sensor.charge = 1;
    state_.tracking.tracker = TrackerKind::lg;
    state_.roi = {0, 0, kSize, kSize};
    state_.slm = slm;
    state_.sensor_epoch = 5;
    auto reference = std::make_shared<Reference>();
    reference->t_taken_ns = 7;
    reference->positions_px = rig_.bench.model_px;
    reference->positions_px.front().x += 0.1;
    reference->standard_error_px.assign(reference->positions_px.size(), Vec2{0.01, 0.01});
    bound_.reference = reference;
  }

  std::unique_ptr<MeasurementPlan> built() {
    EXPECT_TRUE(renew_renderer(state_));
    if (!plans_) plans_.emplace(rig_.pipeline, bench_);
    auto plan = plans_->build(state_, bound_, 3);
    EXPECT_TRUE(plan) << plan.error().reason;
    return plan ? std::move(*plan) : nullptr;
  }

  SensorView view() const {
    auto now = std::make_shared<SensorSnapshot>();
    static_cast<SensorShown&>(*now) = state_;
    now->correction = state_.correction;
    now->optics = optics_of(state_, bench_);
    now->reference = bound_.reference;
    now->slm = state_.slm;
    return now;
  }

  /// Records a plan, with a change of its document, and rebuilds it from the file.
  Result<std::unique_ptr<MeasurementPlan>> rebuilt(
      const MeasurementPlan& plan, const std::function<void(nlohmann::json&)>& change = {}) const {
    const std::string path = own_folder("recorded_plan") + ".h5";
    std::filesystem::remove(path);
    RecordingHeader header;
    header.width = header.height = 64;
    auto file = RecordFile::create(path, header);
    EXPECT_TRUE(file);
    Config config;
    config.slm.geometry = bench_.slm;
    const std::string text = dump_config(config);
    EXPECT_TRUE((*file)->add_document("configuration", sha256_hex(text), text));
    PlanDocuments documents;
    for (Document& one : documents.of(PlanFacts(plan, view()))) {
      if (change && one.kind == "plan") {
        auto content = nlohmann::json::parse(one.text);
        change(content);
        one = make_document("plan", content);
      }
      EXPECT_TRUE((*file)->add_document(one.kind, one.sha256, one.text));
    }
    EXPECT_TRUE((*file)->close({}));
    auto reader = RecordingReader::open(path);
    EXPECT_TRUE(reader);
    auto recorded = RecordedPlans::of(**reader);
    EXPECT_TRUE(recorded);
    std::filesystem::remove(path);
    return recorded->make(plan.id);
  }

  void expect_the_same_plan(const char* what) {
    SCOPED_TRACE(what);
    const auto live = built();
    ASSERT_NE(live, nullptr);
    const auto again = rebuilt(*live);
    ASSERT_TRUE(again) << again.error().reason;
    comparison_.expect_same(*live, **again);
  }

  test::PipelineRig rig_;
  BenchOptics bench_{rig_.bench.optics, rig_.bench.slm};
  SensorState state_;
  Bound bound_;
  std::optional<Plans> plans_;
  Comparison comparison_;
};

TEST_F(RecordedPlan, EqualsTheLivePlanInEveryField) {
  expect_the_same_plan("vortices");
  state_.aberration = {{4, 0.2}};
  state_.correction = {{3, 0.1}, {5, -0.05}};
  expect_the_same_plan("aberration and correction");
  state_.sensor.alternate_charge = 0;
  expect_the_same_plan("vortices and bright spots");
  state_.sensor.alternate_charge = std::nullopt;
  state_.tracking.tracker = TrackerKind::centroid;
  state_.tracking.mode_count = 9;
  state_.sensor.charge = 0;
  expect_the_same_plan("bright spots");
  bound_.reference = nullptr;
  expect_the_same_plan("no reference");
}

TEST_F(RecordedPlan, EqualsTheLivePlanOfAModelReferenceWithALostSpot) {
  auto model = std::make_shared<Reference>(*bound_.reference);
  model->source = ReferenceSource::model;
  model->introduced = {{4, 0.3}};
  model->positions_px[3] = {NAN, NAN};
  bound_.reference = model;
  expect_the_same_plan("model reference");
}

TEST_F(RecordedPlan, EqualsTheLivePlanOfAMeasuredOperator) {
  const auto plan = built();
  auto made = std::make_shared<ModeOperator>();
  made->kind = OperatorKind::measured;
  made->modes_j = plan->reconstructor->modes_j();
  made->slopes = 1.01 * plan->reconstructor->slopes();
  bound_.mode_operator = made;
  expect_the_same_plan("measured operator");
}

TEST_F(RecordedPlan, EqualsTheLivePlanWithTemplatesAndWithoutThem) {
  state_.tracking.tracker = TrackerKind::fit;
  expect_the_same_plan("templates are awaited");
  const auto plan = built();
  auto renderer = SpotRenderer::make(state_.sensor, bench_.slm, bench_.optics, kSize, kSize,
                                     plan->modes_j, {.lit = plan->spots.lit});
  ASSERT_TRUE(renderer);
  OperatingPoint point;
  point.waves.assign(plan->modes_j.size(), 0.0);
  point.waves[3] = 0.01;
  point.reference_waves.assign(plan->modes_j.size(), 0.0);
  point.levels_dn.assign(plan->predicted_px.size(), 100.0);
  point.noise.constant_dn2 = 4.0;
  point.ceiling_dn = 255.0;
  point.lit = int(plan->predicted_px.size());
  point.estimates = state_.tracking.estimates;
  const auto rendered = renderer->render(point.waves, point.fixed);
  state_.templates = {{state_.sensor_epoch, bound_.reference->t_taken_ns, 0},
                      std::make_shared<const FrameFit>(point, rendered, plan->modes_j)};
  expect_the_same_plan("templates");
}

TEST_F(RecordedPlan, EqualsTheLivePlanOfSeveralLightSources) {
  bench_.beams = {{"b", {0.0, 420.0}}, {"c", {430.0, 0.0}}};
  state_.tracking.tracker = TrackerKind::fit;
  expect_the_same_plan("three light sources");
  state_.tracking.tracker = TrackerKind::lg;
  state_.sensor.charge = 2;
  ++state_.sensor_epoch;
  expect_the_same_plan("another charge");
}

TEST_F(RecordedPlan, IsRefusedIfItsLightSourcesDoNotBelongTogether) {
  bench_.beams = {{"b", {0.0, 420.0}}};
  const auto live = built();
  const auto expect_refused = [&](const char* what, auto change) {
    const auto made = rebuilt(*live, change);
    ASSERT_FALSE(made) << what;
    EXPECT_EQ(made.error().code, Errc::invalid) << what;
  };
  using nlohmann::json;
  expect_refused("charge", [](json& plan) { plan["charge"] = std::numeric_limits<int>::min(); });
  expect_refused("huge charge", [](json& plan) { plan["charge"] = 1e30; });
  expect_refused("main", [](json& plan) { plan["beam"] = "x"; });
  expect_refused("nameless", [](json& plan) { plan["beams"][0]["beam"] = ""; });
  expect_refused("many", [](json& plan) { plan["beams"] = json(9, plan["beams"][0]); });
  expect_refused("epoch", [](json& plan) { plan["beams"][0]["sensor_epoch"] = 99; });
  expect_refused("region", [](json& plan) { plan["beams"][0]["roi"]["width"] = 99; });
  expect_refused("lattice", [](json& plan) { plan["sensor"]["subapertures_across"] = 7; });
  expect_refused("number", [](json& plan) { plan["beams"] = 1; });
}

}  // namespace
}  // namespace ovws

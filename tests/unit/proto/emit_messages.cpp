/// Prints every kind of message and result that the encoders produce, and params with the decoders'
/// verdict, as JSON lines for validate_messages.py.
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "config/config.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "proto/encode.hpp"
#include "proto/requests.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/corrector.hpp"
#include "proto/tables/devices.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/job.hpp"
#include "proto/tables/lattices.hpp"
#include "proto/tables/loop.hpp"
#include "proto/tables/picture.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/slm.hpp"
#include "proto/tables/status.hpp"

namespace ovws {
namespace {

using nlohmann::json;

void print(const json& line) {
  std::puts(line.dump().c_str());
}

void print_stream(std::string_view topic, const std::string& text) {
  print(
      {{"schema", "stream." + std::string(topic)}, {"valid", true}, {"value", json::parse(text)}});
}

void print_result(const char* method, const json& value) {
  print({{"schema", method}, {"part", "result"}, {"valid", true}, {"value", value}});
}

const CameraInfo kInfo{"Vendor", "Model", "S1", "127.0.0.1"};
const CameraLimits kLimits{{0, 24, 0},   {10, 1e6, 1},   {0.1, 1000, 0},
                           std::nullopt, {16, 2048, 16}, {2, 2048, 2},
                           2048,         2048,           {PixelFormat::mono8, PixelFormat::mono12}};

void print_frames() {
  const std::array<int, 3> j{1, 2, 3};
  const std::array<float, 3> coefficients{0.125F, -0.03F, 0.5F};
  std::string text;
  std::vector<std::byte> scratch;
  for (const bool valid : {true, false}) {
    WavefrontMessage w;
    w.tracker = "lg";
    w.valid = valid;
    w.rms_waves = 0.5;
    if (valid) w.gain_db = 0.0;
    if (valid) w.pattern = 22;
    w.j = j;
    w.coefficients = w.sigma = coefficients;
    w.fitted = valid;
    encode(w, text);
    print_stream(kTopicWavefront, text);
  }
  for (const bool valid : {true, false}) {
    RefinedMessage r;
    r.valid = valid;
    if (!valid) r.reason = "a \"reason\"";
    r.exposure_us = 2000.0;
    r.j = {1, 2, 3};
    if (valid) {
      r.coefficients = {0.125, -0.03, 0.5};
      r.sigma = {0.001, 0.001, 0.002};
      r.fit = RefinedMessage::Fit{1.0, 500.0, -0.5, 7};
    }
    print_stream(kTopicRefined, encode(r));
  }
  const std::array<SpotFix, 2> spots{};
  SpotsMessage s;
  s.tracker = "thresholded";
  s.charge = 0;
  s.spots = spots;
  (void)encode(s, text, scratch);
  print_stream(kTopicSpots, text);
  const std::array<float, 2> commands{0.5F, -0.25F};
  for (const bool valid : {true, false}) {
    CorrectorMessage c;
    c.tracker = "lg";
    c.valid = valid;
    c.matrix = 3;
    if (valid) c.commands = commands;
    (void)encode(c, text);
    print_stream(kTopicCorrector, text);
  }
}

void print_images() {
  std::string text;
  std::vector<std::byte> scratch;
  const Image<std::uint16_t> deep(4, 3);
  ImageMessage image;
  image.image = view_of(deep, PixelFormat::mono10);
  (void)encode(image, text, scratch);
  print_stream(kTopicImage, text);
  const Image<float> waves(4, 4, std::nanf(""));
  PhaseMessage phase;
  phase.waves = &waves;
  (void)encode(phase, text);
  print_stream(kTopicPhase, text);
}

void print_status() {
  StatusMessage status;
  status.state = "waiting_for_camera";
  for (const bool connected : {false, true}) {
    if (connected) {
      status.camera.info = kInfo;
      status.slm.info = DisplayInfo{"DUMMY1", 1280, 768, 60.0, "x11"};
      status.fault = "none really";
      status.sensor.settings.tracking.mode_operator = OperatorKind::measured;
      status.sensor.mode_operator = {OperatorKind::slopes, "it is being made"};
      status.sensor.reference = "stale";
      status.sensor.reference_introduced_rms_waves = 0.3;
      status.sensor.beams = {{"b", {0.5, 420.25}, true, "0 of 19 spots are found"}};
      status.store = {"/var/lib/ovws", "the disk is full"};
      status.failed_job = {3, "reference.take", "camera.exposure_us", "too bright",
                           1767225600000000000};
      status.refine = {"refining", 5, 1, 640.0, "too dark"};
      status.record = {"ended", "/var/lib/run.h5",       1.5, 700, 1, 699, 2, 3,
                       1 << 20, "stopped by record.stop"};
      for (const char* method : {"record.start", "record.stop", "record.get"}) {
        print_result(method, to_json(status.record));
      }
      print_result("record.estimate", to_json(RecordSize{263493.0, 94.9e9, 1ULL << 40, 11.6}));
      status.counters = {{"frames_grabbed", 5}};
      status.latency = {{"tracked", LatencySummary{5, 1, 2, 3, 4}}};
      status.versions = {{"ovws", "0"}};
    }
    print_stream(kTopicStatus, encode(status));
    print_result("system.status", to_json(status));
  }
  EventMessage event{3, 4, "camera", Severity::warning, "something", {{"field", 1}}};
  print_stream(kTopicEvent, encode(event));
  event.data = nullptr;
  print_stream(kTopicEvent, encode(event));
}

void print_luts() {
  LutReport lut;
  print_result("lut.get", to_json(lut));
  lut.path = "lut.txt";
  print_result("lut.clear", to_json(lut));
  lut.measured = LutMeasured{};
  lut.measured->frames = 3;
  lut.measured->response.levels = 33;
  lut.measured->origin.json = schema("lut.get").at("result").at("examples")[0].at("origin");
  for (const double depth : {0.02, 0.03}) {
    for (std::size_t g = 0; g < 256; ++g) {
      lut.measured->response.phase_rad[g] = depth * double(g);
    }
    lut.measured->table = linearising_lut(lut.measured->response.phase_rad);
    print_result("lut.get", to_json(lut));
    lut.measured->sha256 = "ba7816bf";
  }
  print_result("lut.run", to_json(JobNumber{5}));
}

void print_flatnesses() {
  FlatnessReport flatness;
  print_result("flatness.get", to_json(flatness));
  flatness.path = "flat.png";
  print_result("flatness.clear", to_json(flatness));
  flatness.measured = FlatnessMeasured{};
  flatness.measured->frames = 30;
  flatness.measured->iterations = 4;
  flatness.measured->pupil_diameter_px = 768.0;
  flatness.measured->modes = {{3, 0.1, 0.001}, {4, -0.2, 0.0}};
  flatness.measured->origin.json =
      schema("flatness.get").at("result").at("examples")[0].at("origin");
  print_result("flatness.get", to_json(flatness));
  print_result("flatness.run", to_json(JobNumber{6}));
  print_result("focus.run", to_json(JobNumber{7}));
  print_result("map.run", to_json(JobNumber{9}));
  print_result("slm.settle", to_json(JobNumber{7}));
  print_result("camera.auto_exposure", to_json(JobNumber{8}));
  for (const char* method : {"reference.list", "reference.save", "reference.delete"}) {
    print_result(method,
                 to_json(ReferenceList{{{"one", 1767225600000000000, ""}, {"two", 0, "no"}}}));
  }
  print_result("record.list", to_json(RecordingList{}));
  print_result("record.list", to_json(RecordingList{"/a", {{"b", "/a/b.h5", 5, 7}}, 2}));
  print_result("camera.list", to_json(CameraList{{{"a-b-1", "1", "", true, true}, {}}}));
  print_result("slm.outputs", to_json(OutputList{{{},
                                                  {"HDMI-1", "SLM", true, true, true, 1280, 768,
                                                   60.0, "it is the primary one", true}}}));
  print_result("slm.set", to_json(SlmSettings{"HDMI-1", true, 5.0}));
  print_result("slm.verify", to_json(VerifyReport{7, 0xffffffffU, 1U, 12}));
}

/// Calibrations of every kind of disagreement; `origin` comes from the schema's example.
void print_calibrations() {
  const json example = schema("calibration.get").at("result").at("examples")[0];
  InteractionMatrix matrix;
  matrix.amplitude_waves = {0.1, 0.05};
  matrix.modes_j = {3, 4};
  matrix.slopes = Eigen::MatrixXd::Identity(6, 2);
  matrix.standard_error = 0.01 * Eigen::MatrixXd::Ones(6, 2);
  matrix.lost_spots = {2};
  matrix.dropped = {{5, "it moves no spot"}};
  MatrixComparison comparison;
  comparison.modes = {{3, 1.0, 0.01, 0.999}};  // not every model has every mode
  for (int kind = 0; kind <= int(Disagreement::unlike); ++kind) {
    comparison.disagreement = Disagreement(kind);
    if (kind > 0) comparison.words = "the axes x and y are exchanged";
    print_result("calibration.get",
                 to_json(KnownCalibration{kind > 0, CalibrationReport{0.1,
                                                                      20,
                                                                      1767225600000000000,
                                                                      matrix,
                                                                      comparison,
                                                                      {},
                                                                      "",
                                                                      {example.at("origin")}}}));
  }
  print_result("calibration.clear", to_json(KnownCalibration{}));
  print_result("calibration.run", to_json(JobNumber{4}));
  matrix.source = MatrixSource::set;
  print_result("calibration.set",
               to_json(KnownCalibration{
                   true, CalibrationReport{
                             0.1, 20, 1, matrix, comparison, {}, "", {example.at("origin")}}}));
}

void print_results() {
  const json params{{"gain_db", 500}, {"clamp", true}};
  print_result("camera.get", to_json(CameraReport{}));
  print_result("camera.select", to_json(CameraReport{kInfo, {}, kLimits}));
  print_result("camera.get", to_json(CameraReport{kInfo, {}, kLimits}));
  print_result("camera.set", to_json(CameraSetReport{*CameraSet::decode(params), {}, kLimits}));
  print_result("camera.set", to_json(CameraSetReport{}));
  const SensorReport sensor{{}, {OperatorKind::measured, ""}, 19, {1, 2, 3}, 7};
  print_result("sensor.get", to_json(sensor));
  print_result("sensor.set", to_json(SensorSetReport{
                                 *SensorSet::decode({{"charge", 90}, {"clamp", true}}), {}, 7}));
  RefineSetup refine;
  for (const bool known : {false, true}) {
    if (known) refine.electrons_per_dn = refine.saturation_dn = 40.0;
    print_result("refine.get", to_json(RefineReport{refine}));
    print_result("refine.set",
                 to_json(RefineSetReport{*RefineSet::decode({{"rate_hz", 1e9}, {"clamp", true}}),
                                         {refine}}));
  }
  std::vector<Mode> modes;
  for (int j = 0; j <= kMaxZernikeIndex; ++j) modes.push_back({j, 0.001 * j});
  for (const char* method : {"aberration.get", "aberration.set", "aberration.clear"}) {
    print_result(method, to_json(AberrationReport(modes, {}, 3)));
    print_result(method, to_json(AberrationReport()));
  }
  print_result("aberration.sequence", to_json(AberrationReport({}, {{}, modes}, 3)));
  ReferenceReport reference;
  reference.charge = -1;
  reference.tracker = TrackerKind::weighted;
  reference.positions_px = {{1, 2}};
  reference.standard_error_px = {{0.1, std::nan("")}};
  reference.stale = {{"gain_db", 16.0, 20.0}, {"pixel_format", "Mono8", "Mono12"}};
  reference.origin.json = schema("reference.get").at("result").at("examples")[0].at("origin");
  print_result("reference.set", to_json(KnownReference{reference}));
  print_result("reference.give", to_json(KnownReference{reference}));
  print_result("reference.load", to_json(KnownReference{reference}));
  reference.sha256 = "ba7816bf";
  print_result("reference.get", to_json(KnownReference{reference}));
  print_result("reference.clear", to_json(KnownReference{}));
  print_result("reference.take", to_json(JobNumber{1}));
  LoopReport loop;
  print_result("loop.get", to_json(loop));
  loop.settings.modes = {3, 4};
  loop.settings.gains = {{3, 0.2}};
  loop.settings.offsets = {{4, 0.1}};
  loop.residual_rms_waves = 0.1;
  loop.opened_because = "no usable frame came for 2 s";
  loop.t_opened_ns = 1767225600000000000;
  for (const char* method : {"loop.close", "loop.open", "loop.pause", "loop.get"}) {
    print_result(method, to_json(loop));
  }
  LoopModel model;
  model.modes.push_back(
      {4, {{{0.5, 1.0, 0.05}}, 0.002}, 0.6, {0.02, 1.0}, {0.015, 0.8}, {0.01, 0.6}});
  print_result("loop.model", to_json(KnownLoopModel{}));
  print_result("loop.model", to_json(KnownLoopModel{model}));
  print_result("loop.identify", to_json(JobNumber{2}));
  for (const char* method : {"correction.get", "correction.set", "correction.clear"}) {
    print_result(method, to_json(ModesReport(modes, 3)));
  }
  Registration registration;
  registration.px_per_cycle = {1617.0, -1050.0, 1050.0, 1617.0};
  print_result("registration.get", to_json(KnownRegistration{registration}));
  print_result("registration.clear", to_json(KnownRegistration{}));
  print_result("registration.run", to_json(JobNumber{2}));
  print_result("array.fit", to_json(JobNumber{2}));
  print_calibrations();
  print_luts();
  print_flatnesses();
  for (int k = 0; k <= int(HologramKind::identify); ++k) {
    print_result("slm.show", to_json(ShowReport{HologramKind(k), 1}));
  }
  GrabReport grabbed;
  print_result("camera.grab", to_json(grabbed));
  grabbed.frames.push_back({1, 2, true, 22, 3, 4, 5.0, 6.0, kUnknownGain});
  grabbed.average = true;
  print_result("camera.grab", to_json(grabbed));
  for (const char* const method : {"corrector.set", "corrector.get", "corrector.clear"}) {
    print_result(method, to_json(KnownCorrector{3, 69, {1, 2, 3}, 1, ""}));
    print_result(method, to_json(KnownCorrector{{}, {}, {}, {}, "there is no matrix"}));
  }
  const PreparedLattice lattice{"coarse", {}, 310.0, kUnknownGain, 5.0, 7, 1767225600000000000};
  for (const char* const method : {"lattice.list", "lattice.remove"}) {
    print_result(method,
                 to_json(LatticeList{{{lattice, true, true, ""}, {lattice, false, false, "no"}}}));
  }
  print_result("lattice.prepare", to_json(JobNumber{9}));
  print_result("lattice.use", to_json(LatticeInUse{"coarse", 7, 310.0, 12}));
  print_result("slm.present", to_json(PresentReport{7, 12, std::nullopt, std::nullopt}));
  print_result("slm.present", to_json(PresentReport{7, 12, 1, 2}));
  for (int k = 0; k <= int(JobState::cancelled); ++k) {
    JobReport job{1, "reference.take", JobState(k), 0.5, nullptr, std::nullopt};
    if (job.state == JobState::failed) job.error = Error{Errc::device, "camera", "went away"};
    print_result("job.get", to_json(job));
    print_result("job.cancel", to_json(job));
  }
  Config config;
  print_result("config.get", json::parse(dump_config(config)));
  config.state.directory = "state";
  config.slm.lut = "lut.txt";
  config.optics.centre_px = Vec2{1, 2};
  config.optics.registered = PxPerCycle{0, 1900, 1900, 0};
  config.realtime = RealtimePolicy::enforce;
  config.refine.electrons_per_dn = 40.0;
  print_result("config.get", json::parse(dump_config(config)));
}

/// A random value, sometimes a valid one, for a key of any method.
json any_value(std::mt19937& random) {
  static const json values = json::parse(R"([
      0, 1, -1, 7, 1000, 1e9, -1e9, 0.5, 1.0, null, true, "lg", "model", "square", "flat", "sensor", "grating",
      "identify", "rms", "unit", "Mono12", "nonsense", [], [20, 30], [1, "x"], [1, 2, 3], [4, 4], 0.1, {},
      {"x": 0, "y": 0, "width": 64, "height": 64}, {"x": 0}, [{"j": 3, "waves": 0.5}],
      [{"n": 2, "m": 0, "waves": 0.5}], [{"n": 2, "waves": 1}],
      [{"j": 3, "n": 2, "m": -2, "waves": 1}], [{"j": 3, "gain": 0.2}], [3, 4],
      [{"modes": [{"j": 3, "waves": 0.5}], "norm": "unit"}, {"modes": []}], [{"charge": 0, "tracker": "cell_centroid"}],
      [{"charge": 9, "tracker": "lg"}]])");
  return values[random() % values.size()];
}

/// Params with random values for up to two of `keys`, and for the others those of `given`.
template <class P>
void print_params(const char* method, const std::vector<std::string>& keys, int trials = 1000,
                  const json& given = json::object()) {
  std::mt19937 random(7);
  for (int k = 0; k < trials; ++k) {
    json params = given;
    for (int n = int(random() % 3); n > 0; --n) {
      params[keys[random() % keys.size()]] = any_value(random);
    }
    print({{"schema", method},
           {"part", "params"},
           {"valid", bool(decode_params<P>(params))},
           {"value", params}});
  }
}

void print_all_params() {
  print_params<CameraSet>(
      "camera.set", {"gain_db", "exposure_us", "frame_rate_hz", "pixel_format", "roi", "gian_db"});
  print_params<SensorSet>(
      "sensor.set",
      {"charge", "grid", "subapertures_across", "pupil_diameter_px", "grooves", "spacing",
       "alternate_charge", "charges", "tracker", "operator", "mode_count", "estimates"});
  print_params<RefineSet>("refine.set", {"enabled", "rate_hz", "electrons_per_dn", "read_noise_e",
                                         "black_level_dn", "saturation_dn"});
  print_result("record.estimate", to_json(RecordSize{}));
  print_params<RecordEstimate>("record.estimate", {"pictures_every", "pictures"});
  print_params<RecordStart>("record.start",
                            {"name", "name", "pictures_every", "limit_s", "limit_mib"}, 2000);
  print_params<ModesSet>("aberration.set", {"modes", "modes", "norm"}, 2000);
  print_params<AberrationSequence>("aberration.sequence", {"patterns"}, 4000);
  print_params<ReferenceTake>("reference.take", {"frames", "allow_aberration", "beam", "frame"});
  print_params<LoopSettings>(
      "loop.close",
      {"law", "gain", "leak", "modes", "gains", "offsets", "limit_waves", "patience_s"}, 2000);
  print_params<LoopIdentify>("loop.identify", {"seconds", "second"});
  print_params<LoopOpen>("loop.open", {"keep", "clear"});
  print_params<LoopPause>("loop.pause", {"paused", "pause"});
  print_params<ModesSet>("correction.set", {"modes", "modes", "norm"}, 2000);
  print_params<RegistrationRun>("registration.run", {"frames", "frame"});
  print_params<FlatnessRun>("flatness.run", {"frames", "frame"});
  print_params<FocusRun>("focus.run", {"frames", "frame"});
  print_params<MapRun>("map.run", {"patterns", "frames", "cells", "apply", "frame"});
  print_params<CameraSelect>("camera.select", {"id", "wait", "wait_for"}, 2000);
  print_params<ConfigSave>("config.save", {"preview", "previews"}, 2000);
  print_params<SlmSet>("slm.set", {"display", "allow_primary", "settle_ms", "settle"});
  print_params<SettleRun>("slm.settle", {"repetitions", "watch_ms", "frames"});
  print_params<AutoExposure>("camera.auto_exposure", {"target", "max_exposure_us", "targets"});
  print_params<LutRun>("lut.run", {"levels", "frames", "level"});
  print_params<ArrayFit>("array.fit", {"frames", "frame"});
  print_params<ReferenceSet>("reference.set", {"source"}, 3000);
  print_params<ReferenceGive>("reference.give", {"frames", "frame"});
  print_params<CalibrationRun>("calibration.run", {"amplitude_waves", "frames", "modes", "mode"});
  print_params<CalibrationSet>(
      "calibration.set", {"shape", "modes", "amplitude_waves", "frames", "mode"}, 1000,
      {{"shape", {2, 38, 2}}, {"modes", {3, 4}}, {"amplitude_waves", 0.1}, {"frames", 20}});
  print_params<LatticePrepare>("lattice.prepare", {"frames", "calibrate", "find_exposure", "name"},
                               1000,
                               {{"lattices", {{{"name", "a"}, {"sensor", {{"charge", 0}}}}}}});
  print_params<CorrectorSet>("corrector.set", {"shape", "shapes"}, 3000);
  print_params<SlmShow>("slm.show", {"pattern"});
  print_params<SlmPresent>("slm.present", {"job", "lease_s", "shape", "dtype", "correction",
                                           "flatness", "lut", "inside_pupil", "lease"});
  print_params<CameraGrab>("camera.grab",
                           {"after_hologram", "frames", "average", "region", "timeout_s", "after"});
  print_params<JobNumber>("job.get", {"job", "id"});
  print_params<Nothing>("config.get", {"path"});
}

}  // namespace
}  // namespace ovws

int main() {
  ovws::print_frames();
  ovws::print_images();
  ovws::print_status();
  ovws::print_results();
  ovws::print_all_params();
}

#include <gtest/gtest.h>

#include <set>

#include "core/optics/zernike.hpp"
#include "proto/field_schema.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"
#include "proto/requests.hpp"
#include "proto/schemas.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/experiment.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {
namespace {

using nlohmann::json;

json properties(std::string_view method, const char* part = "params") {
  return json::parse(schema_text(method)).at(part).at("properties");
}

template <class Range>
void expect_range(const json& schema, Range range) {
  EXPECT_EQ(schema.at("minimum"), range.min) << schema;
  EXPECT_EQ(schema.at("maximum"), range.max) << schema;
}

TEST(Schemas, AreThereForEveryStreamAndMethod) {
  std::vector<std::string> names;
  for (const SchemaFile& file : schemas()) names.emplace_back(file.name);
  EXPECT_EQ(names, (std::vector<std::string>{
                       "aberration.clear",   "aberration.get",   "aberration.set",
                       "calibration.clear",  "calibration.get",  "calibration.run",
                       "camera.get",         "camera.set",       "config.get",
                       "config.save",        "correction.clear", "correction.get",
                       "correction.set",     "experiment.cell",  "experiment.gain_sweep",
                       "experiment.get",     "flatness.clear",   "flatness.get",
                       "flatness.run",       "job.cancel",       "job.get",
                       "loop.close",         "loop.get",         "loop.open",
                       "lut.clear",          "lut.get",          "lut.run",
                       "record.get",         "record.start",     "record.stop",
                       "reference.clear",    "reference.get",    "reference.set",
                       "reference.take",     "refine.get",       "refine.set",
                       "registration.clear", "registration.get", "registration.run",
                       "sensor.get",         "sensor.set",       "slm.settle",
                       "slm.show",           "slm.verify",       "stream.event",
                       "stream.image",       "stream.phase",     "stream.refined",
                       "stream.spots",       "stream.status",    "stream.wavefront",
                       "system.describe",    "system.status"}));
  EXPECT_EQ(schema_text("camera.sett"), "");
}

/// Which properties the table's schema has, and the written one: the same, as many of them
/// required.
template <class S>
void expect_same_fields(const char* name, const char* part) {
  json written = json::parse(schema_text(name));
  if (part != nullptr) written = written.at(part);
  const json made =
      schema_of<S>(std::string_view(part == nullptr ? "" : part) == "params" ? SchemaOf::params
                                                                             : SchemaOf::result);
  const auto keys = [](const json& schema) {
    std::set<std::string> all;
    for (const auto& [key, value] : schema.at("properties").items()) all.insert(key);
    return all;
  };
  const auto required = [](const json& schema) {
    return schema.value("required", json::array()).get<std::set<std::string>>();
  };
  EXPECT_EQ(keys(made), keys(written)) << name;
  EXPECT_EQ(required(made), required(written)) << name;
}

TEST(Schemas, HaveTheFieldsOfTheTables) {
  expect_same_fields<CameraReport>("camera.get", "result");
  expect_same_fields<CameraSetReport>("camera.set", "result");
  expect_same_fields<SensorReport>("sensor.get", "result");
  expect_same_fields<SensorSetReport>("sensor.set", "result");
  expect_same_fields<RefineReport>("refine.get", "result");
  expect_same_fields<ModesReport>("aberration.get", "result");
  expect_same_fields<KnownReference>("reference.get", "result");
  expect_same_fields<KnownRegistration>("registration.get", "result");
  expect_same_fields<KnownCalibration>("calibration.get", "result");
  expect_same_fields<LutReport>("lut.get", "result");
  expect_same_fields<FlatnessReport>("flatness.get", "result");
  expect_same_fields<VerifyReport>("slm.verify", "result");
  expect_same_fields<ShowReport>("slm.show", "result");
  expect_same_fields<LoopReport>("loop.get", "result");
  expect_same_fields<RecordReport>("record.get", "result");
  expect_same_fields<JobReport>("job.get", "result");
  expect_same_fields<KnownExperiment>("experiment.get", "result");
  expect_same_fields<CellReport>("experiment.cell", "result");
  expect_same_fields<StatusMessage>("system.status", "result");
  expect_same_fields<LoopSettings>("loop.close", "params");
  expect_same_fields<RecordStart>("record.start", "params");
  expect_same_fields<CalibrationRun>("calibration.run", "params");
  expect_same_fields<GainSweepRun>("experiment.gain_sweep", "params");
  expect_same_fields<ReferenceTake>("reference.take", "params");
  expect_same_fields<SlmShow>("slm.show", "params");
  expect_same_fields<WavefrontMessage>("stream.wavefront", nullptr);
  expect_same_fields<SpotsMessage>("stream.spots", nullptr);
  expect_same_fields<ImageMessage>("stream.image", nullptr);
  expect_same_fields<PhaseMessage>("stream.phase", nullptr);
  expect_same_fields<RefinedMessage>("stream.refined", nullptr);
  expect_same_fields<EventMessage>("stream.event", nullptr);
  expect_same_fields<StreamedStatus>("stream.status", nullptr);
}

TEST(Schemas, StateTheRangesThatAreUsed) {
  const json camera = properties("camera.set");
  expect_range(camera.at("gain_db"), limits::kGainDb);
  expect_range(camera.at("exposure_us"), limits::kExposureUs);
  expect_range(camera.at("frame_rate_hz"), limits::kFrameRateHz);
  const json roi = camera.at("roi").at("properties");
  expect_range(roi.at("x"), limits::kRoiOffset);
  expect_range(roi.at("y"), limits::kRoiOffset);
  expect_range(roi.at("width"), limits::kRoiSize);
  expect_range(roi.at("height"), limits::kRoiSize);
  const json sensor = properties("sensor.set");
  expect_range(sensor.at("charge"), limits::kCharge);
  expect_range(sensor.at("subapertures_across"), limits::kSubaperturesAcross);
  expect_range(sensor.at("pupil_diameter_px"), limits::kPupilDiameterPx);
  expect_range(sensor.at("grooves").at("items"), limits::kGrooves);
  expect_range(sensor.at("spacing"), limits::kSpacing);
  for (const json& refine : {properties("refine.set"), properties("refine.get", "result"),
                             properties("config.get", "result").at("refine").at("properties")}) {
    expect_range(refine.at("rate_hz"), limits::kRefineRateHz);
    expect_range(refine.at("electrons_per_dn"), limits::kElectronsPerDn);
    expect_range(refine.at("read_noise_e"), limits::kReadNoiseE);
    expect_range(refine.at("black_level_dn"), limits::kBlackLevelDn);
    expect_range(refine.at("saturation_dn"), limits::kSaturationDn);
  }
  expect_range(properties("reference.take").at("frames"), limits::kReferenceFrames);
  expect_range(properties("registration.run").at("frames"), limits::kPictureFrames);
  expect_range(properties("lut.run").at("levels"), limits::kGreyLevels);
  expect_range(properties("lut.run").at("frames"), limits::kPictureFrames);
  expect_range(properties("flatness.run").at("frames"), limits::kPictureFrames);
  expect_range(properties("slm.settle").at("repetitions"), limits::kSettleRepetitions);
  expect_range(properties("slm.settle").at("watch_ms"), limits::kWatchMs);
  const json loop = properties("loop.close");
  expect_range(loop.at("gain"), limits::kLoopGain);
  expect_range(loop.at("leak"), limits::kLoopLeak);
  expect_range(loop.at("limit_waves"), limits::kLoopLimitWaves);
  expect_range(loop.at("patience_s"), limits::kLoopPatienceS);
  const json calibration = properties("calibration.run");
  expect_range(calibration.at("amplitude_waves"), limits::kPushWaves);
  expect_range(calibration.at("frames"), limits::kPushFrames);
  EXPECT_EQ(calibration.at("modes").at("items").at("maximum"), kMaxZernikeIndex);
  const json sweep = properties("experiment.gain_sweep");
  expect_range(sweep.at("gains_db").at("items"), limits::kGainDb);
  expect_range(sweep.at("picture_gains_db").at("items"), limits::kGainDb);
  expect_range(sweep.at("reference_gain_db"), limits::kGainDb);
  expect_range(sweep.at("frames"), limits::kSweepFrames);
  expect_range(sweep.at("reference_frames"), limits::kSweepFrames);
  EXPECT_EQ(sweep.at("gains_db").at("maxItems"), limits::kSweepGains);
  EXPECT_EQ(sweep.at("picture_gains_db").at("maxItems"), limits::kSweepPictures);
  EXPECT_EQ(sweep.at("aberrations").at("maxItems"), limits::kSweepAberrations);
  EXPECT_EQ(sweep.at("arms").at("maxItems"), limits::kSweepArms);
  expect_range(properties("experiment.cell").at("cell"), limits::kSweepCell);
  const std::size_t cells = limits::kSweepGains * limits::kSweepAberrations * limits::kSweepArms;
  EXPECT_EQ(cells, std::size_t(limits::kSweepCell.max) + 1);
  expect_range(properties("job.get").at("job"), limits::kJob);
  const json by_j = properties("aberration.set").at("modes").at("items").at("oneOf")[0];
  expect_range(by_j.at("properties").at("waves"), limits::kModeWaves);
  EXPECT_EQ(by_j.at("properties").at("j").at("maximum"), kMaxZernikeIndex);
}

TEST(Schemas, StateTheRangesOfTheConfiguration) {
  const json config = properties("config.get", "result");
  const auto group = [&config](const char* name) { return config.at(name).at("properties"); };
  expect_range(group("camera").at("packet_size_bytes"), limits::kPacketSizeBytes);
  expect_range(group("camera").at("transfer_ms"), limits::kTransferMs);
  expect_range(group("slm").at("width"), limits::kSlmSizePx);
  expect_range(group("slm").at("height"), limits::kSlmSizePx);
  expect_range(group("slm").at("pitch_um"), limits::kSlmPitchUm);
  expect_range(group("slm").at("settle_ms"), limits::kSettleMs);
  expect_range(group("optics").at("wavelength_nm"), limits::kWavelengthNm);
  expect_range(group("optics").at("focal_length_mm"), limits::kFocalLengthMm);
  expect_range(group("optics").at("magnification"), limits::kMagnification);
  expect_range(group("optics").at("camera_pitch_um"), limits::kCameraPitchUm);
  expect_range(group("optics").at("centre_px").at("items"), limits::kCentrePx);
  expect_range(group("optics").at("px_per_cycle").at("items"), limits::kPxPerCycle);
  expect_range(group("tracking").at("kernel_radius"), limits::kKernelRadius);
  expect_range(group("stream").at("image_rate_hz"), limits::kImageRateHz);
  expect_range(group("pipeline").at("workers"), limits::kWorkers);
  expect_range(group("pipeline").at("records"), limits::kRecords);
  expect_range(group("pipeline").at("cpus").at("items"), limits::kCpu);
  EXPECT_EQ(group("pipeline").at("cpus").at("maxItems"), limits::kMostCpus);
}

TEST(Schemas, StateTheNamesThatAreUsed) {
  EXPECT_EQ(properties("camera.set").at("pixel_format").at("enum"), json(pixel_format_names()));
  EXPECT_EQ(properties("sensor.set").at("grid").at("enum"), json(grid_names()));
  EXPECT_EQ(properties("sensor.set").at("tracker").at("enum"), json(tracker_names()));
  EXPECT_EQ(properties("sensor.set").at("template").at("enum"), json(template_names()));
  EXPECT_EQ(properties("sensor.set").at("operator").at("enum"), json(operator_names()));
  const json arm = properties("experiment.gain_sweep").at("arms").at("items").at("properties");
  EXPECT_EQ(arm.at("tracker").at("enum"), json(sweep_tracker_names()));
  expect_range(arm.at("charge"), limits::kCharge);
  EXPECT_EQ(properties("slm.show").at("pattern").at("enum"), json(showable_pattern_names()));
  EXPECT_EQ(properties("aberration.set").at("norm").at("enum"), json(norm_names()));
}

TEST(Schemas, GiveExamplesThatTheDecodersTake) {
  const auto examples = [](const char* method) {
    return json::parse(schema_text(method)).at("params").at("examples");
  };
  for (const json& e : examples("camera.set")) EXPECT_TRUE(CameraSet::decode(e)) << e;
  for (const json& e : examples("sensor.set")) EXPECT_TRUE(SensorSet::decode(e)) << e;
  for (const json& e : examples("refine.set")) EXPECT_TRUE(RefineSet::decode(e)) << e;
  for (const json& e : examples("aberration.set")) EXPECT_TRUE(ModesSet::decode(e)) << e;
  for (const json& e : examples("reference.take")) EXPECT_TRUE(decode<ReferenceTake>(e)) << e;
  for (const json& e : examples("registration.run")) EXPECT_TRUE(decode<RegistrationRun>(e)) << e;
  for (const json& e : examples("reference.set")) EXPECT_TRUE(decode<ReferenceSet>(e)) << e;
  for (const json& e : examples("loop.close")) EXPECT_TRUE(decode<LoopSettings>(e)) << e;
  for (const json& e : examples("loop.open")) EXPECT_TRUE(decode<LoopOpen>(e)) << e;
  for (const json& e : examples("calibration.run")) EXPECT_TRUE(decode<CalibrationRun>(e)) << e;
  for (const json& e : examples("experiment.gain_sweep")) EXPECT_TRUE(decode<GainSweepRun>(e)) << e;
  for (const json& e : examples("experiment.cell")) EXPECT_TRUE(decode<ExperimentCell>(e)) << e;
  for (const json& e : examples("lut.run")) EXPECT_TRUE(decode<LutRun>(e)) << e;
  for (const json& e : examples("flatness.run")) EXPECT_TRUE(decode<FlatnessRun>(e)) << e;
  for (const json& e : examples("slm.settle")) EXPECT_TRUE(decode<SettleRun>(e)) << e;
  for (const json& e : examples("slm.show")) EXPECT_TRUE(decode<SlmShow>(e)) << e;
  for (const json& e : examples("record.start")) EXPECT_TRUE(decode<RecordStart>(e)) << e;
  for (const json& e : examples("job.get")) EXPECT_TRUE(decode<JobNumber>(e)) << e;
}

}  // namespace
}  // namespace ovws

/// ovws replay: measures a recording again and compares the results bit for bit.
#include <chrono>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "core/port/clock.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/replay_tally.hpp"
#include "daemon/ovws/parts/part_file.hpp"
#include "daemon/ovws/text/fill.hpp"
#include "daemon/ovwsd/record/loop_player.hpp"
#include "daemon/ovwsd/record/player.hpp"
#include "proto/json_part.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

struct ReplayOptions {
  std::string path;
  double speed = 0.0;  ///< factor to the recorded speed; 0: as fast as possible
  bool step = false;
  bool print_frames = false;
  std::optional<Positions> frames;  ///< positions in the recording; none: all
  std::optional<Shard> shard;       ///< instead of `frames`
  std::string folder;               ///< for a part; empty: prints the results
  bool refine = false;
  RefineOverrides camera;  ///< used with `refine` only
};

/// The recording of a part: parts of different recordings are not joined.
json identity_of(const std::string& path, const RecordingReader& reader) {
  return {{"file", fs::path(path).filename().string()},
          {"program", reader.header().program},
          {"t_begin_ns", reader.header().t_begin_ns},
          {"frames", reader.frames().size()}};
}

json refined_content(const RefinedFrame& refined) {
  json out{{"valid", refined.refusal.empty()},
           {"reason", text_or_null(refined.refusal)},
           {"against_reference", refined.against_reference},
           {"coefficients", nullptr},
           {"sigma", nullptr},
           {"fit", nullptr}};
  if (!refined.modes) return out;
  const RefinedModes& modes = *refined.modes;
  out["coefficients"] = modes.waves;
  out["sigma"] = modes.sigma_waves;
  out["fit"] = {{"chi2_per_pixel", modes.chi2_per_pixel},
                {"peak_e", modes.peak_e},
                {"background_e", modes.background_e},
                {"iterations", modes.iterations}};
  return out;
}

json frame_line(const PlayedFrame& frame, std::size_t row, bool refine) {
  json out{{"row", row},
           {"frame_id", frame.recorded.frame_id},
           {"t_arrival_ns", frame.recorded.t_arrival_ns},
           {"replayed", frame.replayed},
           {"reason", text_or_null(frame.reason)},
           {"same", frame.same},
           {"valid", frame.valid},
           {"j", frame.modes_j},
           {"coefficients", nullptr},
           {"sigma", nullptr}};
  if (refine) out["refined"] = frame.refined ? refined_content(*frame.refined) : json();
  if (!frame.valid) return out;
  out["coefficients"] = frame.coefficients;
  out["sigma"] = frame.sigma_waves;
  return out;
}

/// Sleeps until the frame is due: its recorded time since the first frame, divided by `speed`.
void wait_for(const PlayedFrame& frame, std::int64_t first_ns, std::int64_t begun_ns,
              double speed) {
  if (speed <= 0.0) return;
  constexpr double kMaxWaitNs = 1e18;  // limit of the clock's range
  const double after_ns =
      std::min(double(frame.recorded.t_arrival_mono_ns - first_ns) / speed, kMaxWaitNs);
  const double now_ns = double(monotonic_ns() - begun_ns);
  if (after_ns > now_ns)
    std::this_thread::sleep_for(std::chrono::duration<double, std::nano>(after_ns - now_ns));
}

/// Waits for a line on standard input. False: end of input.
bool wait_for_enter() {
  std::string line;
  return bool(std::getline(std::cin, line));
}

json loop_content(const PlayedLoop& loop) {
  if (loop.runs == 0 && loop.reason.empty()) return nullptr;
  return {{"runs", loop.runs},
          {"decisions", loop.decisions},
          {"same", loop.same},
          {"first_difference", text_or_null(loop.first_difference)},
          {"not_all_because", text_or_null(loop.reason)}};
}

/// `played`: none if the frames are only a part of the recording.
int print_summary(const Common& common, const ReplayOptions& options, const ReplayTally& tally,
                  const std::optional<PlayedLoop>& played) {
  const PlayedLoop loop = played.value_or(PlayedLoop{});
  const bool all_same = tally.same == tally.replayed && loop.same == loop.decisions &&
                        tally.replayed + loop.decisions > 0;
  json summary = tally.content();
  summary["loop"] = loop_content(loop);
  print_result(common, summary,
               tally.text(options.path) +
                   fill("[loop?\nclosed loop: closed {loop.runs} times, {loop.decisions} decisions "
                        "repeated, {loop.same} of them bit for bit the same"
                        "[loop.first_difference?\nfirst different decision: after "
                        "{loop.first_difference}][loop.not_all_because?\nnot all decisions were "
                        "repeated: {loop.not_all_because}]]",
                        summary));
  return all_same ? kOk : kError;
}

/// The settings with which frames are refined: those of the recording's configuration, with the
/// values of the command line.
Result<RefineSetup> refine_setup(const Config& config, const RefineOverrides& camera) {
  RefineSetup setup = camera.on(config.refine);
  setup.enabled = true;
  if (auto usable = check_refine(setup); !usable) {
    return fail(Errc::invalid, "--refine",
                usable.error().field + " " + usable.error().reason + ": see ovws replay --help");
  }
  return setup;
}

/// The frames of a recording that a command replays.
struct Selected {
  std::unique_ptr<Player> player;
  std::size_t frames = 0;  ///< of the recording
  Positions range;
  json refine;  ///< settings; null: frames are not refined
};

Result<Selected> select(const ReplayOptions& options) {
  auto player = Player::open(options.path);
  if (!player) return fail(player.error());
  const std::uint64_t frames = (*player)->reader().frames().size();
  Selected out{std::move(*player), frames, options.frames.value_or(Positions{0, frames}), {}};
  if (options.shard) out.range = consecutive(*options.shard, frames);
  if (out.range.end > frames) {
    return fail(Errc::invalid, "frames",
                fmt::format("{} is not in the recording, which has the frames {}",
                            text_of(out.range), text_of(Positions{0, frames})));
  }
  out.player->select(out.range.begin, out.range.end);
  if (!options.refine) return out;
  const auto config = out.player->configuration();
  if (!config) return fail(config.error());
  const auto setup = refine_setup(*config, options.camera);
  if (!setup) return fail(setup.error());
  out.player->refine(*setup, config->slm.geometry);
  out.refine = {{"electrons_per_dn", *setup->electrons_per_dn},
                {"read_noise_e", setup->read_noise_e},
                {"black_level_dn", setup->black_level_dn},
                {"saturation_dn", setup->saturation_dn ? json(*setup->saturation_dn) : json()},
                {"pixel_format", pixel_format_name(setup->format)}};
  return out;
}

Result<fs::path> write_replay_part(const ReplayOptions& options, Selected& selected) {
  PartHead head;
  head.part_of = kPartOfReplay;
  head.version = OVWS_VERSION;
  head.options = {{"recording", identity_of(options.path, selected.player->reader())},
                  {"refine", selected.refine}};
  head.items = selected.frames;
  head.share = text_of(selected.range);
  const std::string name = options.shard ? part_name(*options.shard) : part_name(selected.range);
  return write_part(options.folder, name, head, [&](const AddItem& add) -> Result<void> {
    for (std::size_t row = selected.range.begin; row < selected.range.end; ++row) {
      const auto played = selected.player->step();
      if (!played) return fail(played.error());
      add(row, json_text(frame_line(**played, row, options.refine)));
    }
    return {};
  });
}

int replay_recording(const Common& common, const ReplayOptions& options) {
  auto selected = select(options);
  if (!selected) return report(common, selected.error());
  Player& player = *selected->player;
  if (!options.folder.empty()) {
    const auto part = write_replay_part(options, *selected);
    return part ? report_file(common, part->string()) : report(common, part.error());
  }
  std::optional<std::int64_t> first_ns;
  const std::int64_t begun_ns = monotonic_ns();
  ReplayTally tally;
  for (std::size_t row = selected->range.begin;; ++row) {
    const auto played = player.step();
    if (!played) return report(common, played.error());
    if (!*played) break;
    const json line = frame_line(**played, row, options.refine);
    tally.count(line);
    if (!first_ns) first_ns = (*played)->recorded.t_arrival_mono_ns;
    wait_for(**played, *first_ns, begun_ns, options.speed);
    if (options.print_frames || options.step) print("{}\n", json_text(line));
    if (!options.step) continue;
    std::fflush(stdout);
    if (!wait_for_enter()) break;
  }
  if (selected->range != Positions{0, selected->frames}) {
    return print_summary(common, options, tally, std::nullopt);
  }
  const auto loop = replay_loop(player.reader());
  if (!loop) return report(common, loop.error());
  return print_summary(common, options, tally, *loop);
}

}  // namespace

RefineSetup RefineOverrides::on(RefineSetup setup) const {
  if (electrons_per_dn) setup.electrons_per_dn = electrons_per_dn;
  if (read_noise_e) setup.read_noise_e = *read_noise_e;
  if (black_level_dn) setup.black_level_dn = *black_level_dn;
  if (saturation_dn) setup.saturation_dn = saturation_dn;
  return setup;
}

void add_refine_camera(CLI::App& command, RefineOverrides& camera, CLI::Option* refine,
                       const char* electrons_help) {
  command.add_option("--electrons-per-dn", camera.electrons_per_dn, electrons_help)
      ->check(number_from(limits::kElectronsPerDn))
      ->needs(refine);
  command
      .add_option("--read-noise", camera.read_noise_e, "for --refine: read noise, electrons RMS")
      ->check(number_from(limits::kReadNoiseE))
      ->needs(refine);
  command.add_option("--black-level", camera.black_level_dn, "for --refine: black level, DN")
      ->check(number_from(limits::kBlackLevelDn))
      ->needs(refine);
  command
      .add_option("--saturation", camera.saturation_dn,
                  "for --refine: ignore pixels from this DN on")
      ->check(number_from(limits::kSaturationDn))
      ->needs(refine);
}

void add_replay(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "replay",
      "measure the images of a recording again with the recorded settings and compare the results; "
      "exit code 1 if they differ or if there is nothing to measure",
      replay_recording);
  command.add_option("file", options.path, "recording made by record.start")->required();
  auto* speed =
      command
          .add_option("--speed", options.speed, "1: as recorded; 0 (default): as fast as possible")
          ->check(number_from(0.0, 1e6));
  auto* step =
      command.add_flag("--step", options.step, "measure one frame at a time; Enter continues");
  auto* frames =
      command
          .add_option_function<std::string>(
              "--frames",
              [&options = options](const std::string& text) {
                options.print_frames = true;
                if (!text.empty()) options.frames = *parse_range(text);
              },
              "print each frame as one line of JSON; with A:B only the frames at the positions A "
              "to B-1 of the recording, counted from 0")
          ->expected(0, 1)
          ->type_name("[A:B]")
          ->check([](const std::string& text) {
            const std::string wrong = text.empty() ? "" : why_refused(parse_range(text));
            return wrong.empty() ? wrong : wrong + "; without a range, give it after the file";
          });
  add_shard(command, options.shard,
            "replay only the i-th of N nearly equal ranges of frames, 1/N to N/N")
      ->excludes(frames);
  command
      .add_option("--output,-o", options.folder,
                  "write the frames to this folder, as a part for ovws merge, which then reports "
                  "differences")
      ->excludes(speed)
      ->excludes(step);
  auto* refine = command.add_flag(
      "--refine", options.refine,
      "also fit all pixels of the spots of each frame with the camera's noise; each value below "
      "replaces that of refine in the recording's configuration");
  add_refine_camera(
      command, options.camera, refine,
      "for --refine: electrons per DN of the configured pixel format at a gain of 0 dB");
}

}  // namespace ovws::cli

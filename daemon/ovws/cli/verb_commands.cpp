#include <CLI/CLI.hpp>
#include <memory>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "proto/limits.hpp"

namespace ovws::cli {
namespace {

using Words = std::vector<std::string>;

void add_exposure(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "exposure", "set or show the camera's exposure time, or let the daemon find it");
  auto time = std::make_shared<std::string>();
  command->add_option(
      "time", *time,
      "time with its unit: 2ms, 2000us, 0.5s; or auto: most spots reach up to 70 % of "
      "full scale");
  command->callback([&common, &status, time] { status = exposure_verb(common, *time); });
}

void add_gain(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("gain", "set or show the camera's gain");
  auto gain = std::make_shared<std::string>();
  command->add_option("gain", *gain, "gain, dB: 12");
  command->callback([&common, &status, gain] { status = gain_verb(common, *gain); });
}

void add_rate(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "rate", "set the camera's frame rate, or show it with the rate that is measured");
  auto rate = std::make_shared<std::string>();
  command->add_option("rate", *rate, "frames per second, Hz: 100");
  command->callback([&common, &status, rate] { status = rate_verb(common, *rate); });
}

void add_aberrate(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "aberrate", "introduce an aberration instead of the present one, or show the present one");
  auto words = std::make_shared<Words>();
  command->add_option(
      "modes", *words,
      "MODE=WAVES, e.g. vertical-coma=0.2; modes as in ovws call --help. norm=unit: "
      "amplitudes at the pupil's edge instead of RMS");
  command->callback([&common, &status, words] { status = aberrate_verb(common, *words); });
}

void add_clear(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "clear", "remove the introduced aberration, and say what correction stays");
  command->callback([&common, &status] { status = clear_verb(common); });
}

void add_focus(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "focus", "measure how far the camera is from the focus, and the aberrations of the light");
  auto words = std::make_shared<Words>();
  command->add_option("params", *words, "params of focus.run: frames=20");
  command->callback([&common, &status, words] { status = focus_verb(common, *words); });
}

void add_reference(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "reference", "take a reference, show the present one, or keep several by name");
  auto action = std::make_shared<std::string>();
  auto words = std::make_shared<Words>();
  command
      ->add_option("action", *action,
                   "take one: number of frames to average, e.g. 100; or save, load, delete, list")
      ->check(CLI::Range(limits::kReferenceFrames.min, limits::kReferenceFrames.max) |
              CLI::IsMember({"save", "load", "delete", "list"}));
  command->add_option("params", *words,
                      "NAME to save, load or delete; or further params of reference.take: "
                      "allow_aberration=true");
  command->callback(
      [&common, &status, action, words] { status = reference_verb(common, *action, *words); });
}

void add_loop(CLI::App& app, const Common& common, int& status) {
  auto* command =
      app.add_subcommand("loop",
                         "close, open, pause or resume the loop, remove its correction, or "
                         "show its state");
  auto action = std::make_shared<std::string>();
  auto words = std::make_shared<Words>();
  command
      ->add_option("action", *action,
                   "what to do; clear removes the correction that an open loop has left")
      ->check(CLI::IsMember({"close", "open", "pause", "resume", "clear"}));
  command->add_option("params", *words,
                      "params of loop.close or loop.open: gain=0.3 modes=3,4,5, keep=false");
  command->callback(
      [&common, &status, action, words] { status = loop_verb(common, *action, *words); });
}

void add_record(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "record",
      "record every frame into a file of the daemon's recordings until the duration has passed or "
      "Ctrl-C is pressed, or show the state of the recording");
  auto words = std::make_shared<std::vector<std::string>>();
  command->add_option(
      "words", *words,
      "NAME of the file without .h5 (default: run- and the time), then DURATION with "
      "its unit: 60s, 10min, 2h (default: until Ctrl-C); and further params of "
      "record.start: pictures_every=10 limit_mib=20000");
  command->callback([&common, &status, words] { status = record_verb(common, *words); });
}

}  // namespace

void add_verbs(CLI::App& app, const Common& common, int& status) {
  add_exposure(app, common, status);
  add_gain(app, common, status);
  add_rate(app, common, status);
  add_aberrate(app, common, status);
  add_clear(app, common, status);
  add_focus(app, common, status);
  add_reference(app, common, status);
  add_loop(app, common, status);
  add_record(app, common, status);
}

}  // namespace ovws::cli

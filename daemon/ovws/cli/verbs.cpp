/// Plain verbs for daily work: ovws exposure, gain, rate, aberrate, clear, focus, reference, loop
/// and record.
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/request.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/params.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "daemon/ovws/text/status.hpp"
#include "daemon/shared/schemas/schemas.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

/// Calls a method, waits for its job, and prints the result. Returns an exit code.
int act(const Common& common, const std::string& method, const json& params) {
  const json answer = needed(call_and_wait(common, method, params));
  return print_result(common, answer, answer_text(method, answer), kAnswerIndent);
}

/// As above, with params from words.
int act_on_words(const Common& common, const std::string& method, const Words& words) {
  const auto params = params_of(schema(method).at("params"), words);
  return params ? act(common, method, *params) : report_mistake(common, params.error());
}

int report_mistake_in(const Common& common, const std::string& key, Error error) {
  error.field = key;
  return report_mistake(common, error);
}

/// A setting of the camera as people write and read it.
struct CameraWords {
  const char *what, *field;  ///< in sentences; in mistakes
  const char* key;
  double per_unit;  ///< of the key, for one of what `read` returns
  Result<double> (*read)(std::string_view text);
  std::string (*show)(const json& settings, const json& limits);
};

/// Sets the setting, or reads it if the text is empty, and prints it.
int act_on_camera(const Common& common, const CameraWords& words, const std::string& text) {
  json params = json::object();
  if (!text.empty()) {
    const auto value = words.read(text);
    if (!value) return report_mistake_in(common, words.field, value.error());
    params[words.key] = words.per_unit * *value;
  }
  const json answer = needed(call(common, text.empty() ? "camera.get" : "camera.set", params));
  const json& settings = answer.at(text.empty() ? "settings" : "applied");
  return print_result(common, answer,
                      words.what + (" " + words.show(settings, answer.at("limits"))),
                      kAnswerIndent);
}

/// Warns on stderr that the further question of a verb that has done its work was not answered.
void warn_about(const char* what, const CallFailure& failure) {
  fmt::print(stderr, "ovws: warning: {} is not known: {}\n", what,
             failure.error.value("message", "unknown error"));
}

/// Shows the recording until it ends or Ctrl-C ends it. Returns the last result of record.get.
Answer end_of_recording(const Common& common, std::optional<double> duration_s) {
  while (!was_interrupted()) {
    auto report = call_patiently(common, "record.get", json::object());
    if (!report || report->at("state") != "recording") return report;
    const double passed_s = report->at("duration_s").get<double>();
    std::string text = fmt::format("recording: {}, {} frames, {}", time_text(std::round(passed_s)),
                                   report->at("frames").get<std::uint64_t>(),
                                   size_text(report->at("bytes").get<double>()));
    if (duration_s) {
      text += "; " + time_text(std::max(0.0, std::ceil(*duration_s - passed_s))) + " left";
    }
    study::print_progress(text + "; Ctrl-C stops");
    std::this_thread::sleep_for(kPollInterval);
  }
  auto stopped = call_patiently(common, "record.stop", json::object());
  // Refused: the recording has ended by itself meanwhile.
  return stopped ? stopped : call(common, "record.get", json::object());
}

/// Whether the recording ended as it was asked to.
bool has_ended_well(const json& record) {
  const std::string reason = record.at("reason").is_string() ? record.at("reason") : json("");
  return reason == "stopped by record.stop" ||
         (reason.starts_with("limit_") && reason.ends_with("is reached"));
}

int exposure_verb(const Common& common, const std::string& time) {
  if (time == "auto") return act(common, "camera.auto_exposure", json::object());
  return act_on_camera(
      common, {"exposure", "exposure", "exposure_us", 1e6, seconds_of, exposure_text}, time);
}

int gain_verb(const Common& common, const std::string& gain) {
  return act_on_camera(common, {"gain", "gain", "gain_db", 1.0, decibels_of, gain_text}, gain);
}

int show_rate(const Common& common) {
  json answer = needed(call(common, "camera.get", json::object()));
  std::string text = "frame rate " + rate_text(answer.at("settings"), answer.at("limits"));
  const auto status = call(common, "system.status", json::object());
  answer["rates"] = status ? status->at("rates") : json();
  if (status) text += "; measured: " + measured_rate_text(*status);
  print_result(common, answer, text, kAnswerIndent);
  if (!status) warn_about("the measured rate", status.error());
  return kOk;
}

int rate_verb(const Common& common, const std::string& rate) {
  if (rate.empty()) return show_rate(common);
  return act_on_camera(common, {"frame rate", "rate", "frame_rate_hz", 1.0, hertz_of, rate_text},
                       rate);
}

int aberrate_verb(const Common& common, const Words& words) {
  if (words.empty()) return act(common, "aberration.get", json::object());
  Words of_method;
  for (const std::string& word : words) {
    const auto equals = word.find('=');
    if (equals == std::string::npos) {
      return report_mistake(common,
                            {Errc::invalid, word, "give MODE=WAVES, e.g. vertical-coma=0.2"});
    }
    of_method.push_back((word.starts_with("norm=") ? "" : "modes.") + word);
  }
  return act_on_words(common, "aberration.set", of_method);
}

/// Removes the introduced aberration, and says what correction stays.
int clear_verb(const Common& common, const NoOptions&) {
  json answer = needed(call_and_wait(common, "aberration.clear", json::object()));
  std::string text = answer_text("aberration.clear", answer);
  const auto correction = call(common, "correction.get", json::object());
  const auto loop = correction ? call(common, "loop.get", json::object()) : correction;
  answer["correction"] = correction ? *correction : json();
  if (loop) {
    const std::string stays = correction_text(correction->at("modes"), *loop);
    if (!stays.empty()) text += "\nthe correction stays: " + stays;
  }
  print_result(common, answer, text, kAnswerIndent);
  if (!loop) warn_about("the correction that stays", loop.error());
  return kOk;
}

int focus_verb(const Common& common, const Words& words) {
  return act_on_words(common, "focus.run", words);
}

struct ActionWords {
  std::string action;
  Words words;
};

int reference_verb(const Common& common, const ActionWords& given) {
  const auto& [action, words] = given;
  if (action.empty()) return act(common, "reference.get", json::object());
  if (action == "list") return act_on_words(common, "reference.list", words);
  Words of_method = words;
  if (action != "save" && action != "load" && action != "delete") {  // a number of frames
    of_method.push_back("frames=" + action);
    return act_on_words(common, "reference.take", of_method);
  }
  if (words.size() != 1) {
    return report_mistake(common, {Errc::invalid, "name", "give the name of one reference"});
  }
  return act_on_words(common, "reference." + action, {"name=" + words.front()});
}

int loop_verb(const Common& common, const ActionWords& given) {
  const auto& [action, words] = given;
  if (action.empty()) return act(common, "loop.get", json::object());
  if (action == "clear") return act_on_words(common, "correction.clear", words);
  if (action == "pause" || action == "resume") {
    Words of_method = words;
    of_method.push_back(action == "pause" ? "paused=true" : "paused=false");
    return act_on_words(common, "loop.pause", of_method);
  }
  return act_on_words(common, "loop." + action, words);
}

/// Records until the duration has passed, or until Ctrl-C, and shows the progress. `words`: a name,
/// a duration, and params of record.start as KEY=VALUE, each may be left out; none: shows the
/// state.
int record_verb(const Common& common, const std::vector<std::string>& words) {
  if (words.empty()) return act(common, "record.get", json::object());
  Words named, plain;
  for (const std::string& word : words) {
    (word.find('=') == std::string::npos ? plain : named).push_back(word);
  }
  auto params = params_of(schema("record.start").at("params"), named);
  if (!params) return report_mistake(common, params.error());
  // A lone number is a duration without its unit, not a name: as a name it would record without
  // end.
  const auto is_number = [](const std::string& word) {
    return word.find_first_not_of("0123456789.") == std::string::npos;
  };
  const bool is_named = plain.size() > 1 || (plain.size() == 1 && !is_number(plain.front()) &&
                                             !seconds_of(plain.front()));
  if (is_named) (*params)["name"] = plain.front();
  std::optional<double> duration_s;
  if (plain.size() > (is_named ? 1 : 0)) {
    const auto seconds = seconds_of(plain[is_named ? 1 : 0]);
    if (!seconds) return report_mistake_in(common, "duration", seconds.error());
    (*params)["limit_s"] = *seconds;
    duration_s = *seconds;
  }
  if (plain.size() > 2) {
    return report_mistake(common, {Errc::invalid, plain[2], "give the name and the duration only"});
  }
  catch_interrupts();  // before the start, which takes seconds if the disk is slow
  needed(call(common, "record.start", *params));
  auto record = end_of_recording(common, duration_s);
  study::print_progress("");
  const json ended = needed(std::move(record));
  print_result(common, ended, answer_text("record.get", ended), kAnswerIndent);
  return has_ended_well(ended) ? kOk : kError;
}

}  // namespace

void add_verbs(CLI::App& app, const Common& common, int& status) {
  const auto verb = [&]<class Options>(const char* name, const char* help,
                                       int (*run)(const Common&, const Options&)) {
    return add_command(app, common, status, name, help, run);
  };
  const auto verb_of = [&](const char* name, const char* help, auto run, const char* argument,
                           const char* argument_help) {
    auto added = verb(name, help, run);
    added.syntax.add_option(argument, added.options, argument_help);
  };
  verb_of("exposure", "set or show the camera's exposure time, or let the daemon find it",
          exposure_verb, "time",
          "time with its unit: 2ms, 2000us, 0.5s; or auto: most spots reach up to 70 % of full "
          "scale");
  verb_of("gain", "set or show the camera's gain", gain_verb, "gain", "gain, dB: 12");
  verb_of("rate", "set the camera's frame rate, or show it with the rate that is measured",
          rate_verb, "rate", "frames per second, Hz: 100");
  verb_of("aberrate", "introduce an aberration instead of the present one, or show the present one",
          aberrate_verb, "modes",
          "MODE=WAVES, e.g. vertical-coma=0.2; modes as in ovws call --help. norm=unit: amplitudes "
          "at the pupil's edge instead of RMS");
  verb("clear", "remove the introduced aberration, and say what correction stays", clear_verb);
  verb_of("focus", "measure how far the camera is from the focus, and the aberrations of the light",
          focus_verb, "params", "params of focus.run: frames=20");
  auto reference =
      verb("reference", "take a reference, show the present one, or keep several by name",
           reference_verb);
  reference.syntax
      .add_option("action", reference.options.action,
                  "take one: number of frames to average, e.g. 100; or save, load, delete, list")
      ->check(CLI::Range(limits::kReferenceFrames.min, limits::kReferenceFrames.max) |
              CLI::IsMember({"save", "load", "delete", "list"}));
  reference.syntax.add_option("params", reference.options.words,
                              "NAME to save, load or delete; or further params of "
                              "reference.take: allow_aberration=true");
  auto loop = verb(
      "loop", "close, open, pause or resume the loop, remove its correction, or show its state",
      loop_verb);
  loop.syntax
      .add_option("action", loop.options.action,
                  "what to do; clear removes the correction that an open loop has left")
      ->check(CLI::IsMember({"close", "open", "pause", "resume", "clear"}));
  loop.syntax.add_option("params", loop.options.words,
                         "params of loop.close or loop.open: gain=0.3 modes=3,4,5, keep=false");
  verb_of("record",
          "record every frame into a file of the daemon's recordings until the duration has passed "
          "or Ctrl-C is pressed, or show the state of the recording",
          record_verb, "words",
          "NAME of the file without .h5 (default: run- and the time), then DURATION with its unit: "
          "60s, 10min, 2h (default: until Ctrl-C); and further params of record.start: "
          "pictures_every=10 limit_mib=20000");
}

}  // namespace ovws::cli

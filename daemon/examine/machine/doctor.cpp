#include "daemon/examine/machine/doctor.hpp"

#include <iterator>
#include <thread>

#include "proto/endpoint.hpp"
#include "proto/json_text.hpp"
#include "proto/slow_camera.hpp"

namespace ovws::examine {
namespace {

constexpr double kOpening_s = 5.0;
constexpr int kMostAsked = 12;  // a daemon that crashes starts again and again

/// Whether this is the answer of a daemon that may still be opening its devices.
bool is_opening(const DaemonFacts& facts) {
  const auto uptime_s = facts.status ? number_at(*facts.status, "/uptime_s") : std::nullopt;
  if (!uptime_s) return false;
  const std::string state = text_at(*facts.status, "/state");
  const bool waits = state == "starting" || state.starts_with("waiting") ||
                     (state == "fault" && camera_of(facts) == DaemonsCamera::without);
  return waits && *uptime_s < kOpening_s;
}

void add(Findings& all, Findings more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

void add_not_here(Findings& all, const char* name, const char* why) {
  all.push_back(not_here(why));
  all.back().name = name;
}

StateFacts state_of_daemon(const DaemonFacts& daemon) {
  const std::string folder = text_at(*daemon.status, "/store/directory");
  return read_state_of_daemon(folder.empty() ? std::nullopt : std::optional(folder));
}

}  // namespace

DaemonFacts ask_opened(const AskDaemon& ask, const std::string& endpoint,
                       std::chrono::milliseconds pause) {
  DaemonFacts facts = ask(endpoint);
  for (int asked = 1; is_opening(facts) && asked < kMostAsked; ++asked) {
    std::this_thread::sleep_for(pause);
    facts = ask(endpoint);
  }
  return facts;
}

DaemonsCamera camera_of(const DaemonFacts& facts) {
  if (!facts.status) return DaemonsCamera::silent;
  const nlohmann::json::json_pointer info("/camera/info");
  const bool has = facts.status->contains(info) && facts.status->at(info).is_object();
  return has ? DaemonsCamera::with : DaemonsCamera::without;
}

Findings examine_all(const std::string& path, const std::string& endpoint, const AskDaemon& ask) {
  ConfigurationFacts configuration = read_configuration(path);
  const Config file = configuration.config.value_or(Config{});
  DaemonFacts daemon =
      ask_opened(ask, endpoint.empty() ? local_endpoint(file.control.endpoint) : endpoint);
  daemon.asks_for_keys = file.security.secret_key.has_value();
  const auto in_use = parse_config(json_text(daemon.config));
  const bool is_of_daemon = path.empty() && in_use && is_reached_from_here_only(daemon.endpoint);
  if (is_of_daemon) judge_instead(configuration, *in_use, daemon.endpoint);
  const Config config = configuration.config.value_or(Config{});
  Findings found = answers(configuration);
  if (configuration.config) {
    add(found, answers(read_camera(config.camera, camera_of(daemon))));
    if (config.modulator == Modulator::fixed) {
      add_not_here(found, "slm", "a fixed array of lenslets needs no display");
    } else {
      add(found, answers(read_display(config.slm, shows_holograms(daemon))));
    }
    add(found, answers(is_of_daemon ? state_of_daemon(daemon)
                                    : read_state(config.state, configuration.path)));
  } else {
    for (const char* name : {"camera", "slm", "state"}) {
      add_not_here(found, name, "the configuration could not be loaded");
    }
  }
  add(found, answers(read_host(config.realtime)));
  add(found, answers(daemon, kDoctor));
  return found;
}

}  // namespace ovws::examine

#include "daemon/examine/machine/doctor.hpp"

#include <iterator>

#include "daemon/examine/machine/camera.hpp"
#include "daemon/examine/machine/configuration.hpp"
#include "daemon/examine/machine/display.hpp"
#include "daemon/examine/machine/host.hpp"
#include "daemon/examine/machine/state.hpp"
#include "proto/endpoint.hpp"

namespace ovws::doctor {
namespace {

void add(Findings& all, Findings more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

Findings examine(const std::string& path, const std::string& endpoint, const AskDaemon& ask) {
  ConfigurationFacts configuration = read_configuration(path);
  const Config file = configuration.config.value_or(Config{});
  DaemonFacts daemon =
      ask_opened(ask, endpoint.empty() ? local_endpoint(file.control.endpoint) : endpoint);
  daemon.asks_for_keys = file.security.secret_key.has_value();
  const bool is_of_daemon =
      path.empty() && daemon.config && is_reached_from_here_only(daemon.endpoint);
  if (is_of_daemon) {
    judge_instead(configuration, *daemon.config, daemon.endpoint, layout_fault_of(daemon));
  }
  const Config config = configuration.config.value_or(Config{});
  Findings found = judge(configuration);
  if (configuration.config) {
    add(found, judge(read_camera(config.camera, camera_of(daemon))));
    if (config.modulator == Modulator::fixed) {
      found.push_back(not_here("a fixed array of lenslets needs no display"));
      found.back().name = "slm";
    } else {
      add(found, judge(read_display(config.slm, shows_holograms(daemon))));
    }
    add(found,
        judge(is_of_daemon ? read_state_of_daemon(state_folder_of(daemon), store_fault_of(daemon))
                           : read_state(config.state)));
  } else {
    for (const char* name : {"camera", "slm", "state"}) {
      found.push_back(not_here("the configuration could not be loaded"));
      found.back().name = name;
    }
  }
  add(found, judge(read_host(config.realtime)));
  add(found, judge(daemon));
  return found;
}

}  // namespace ovws::doctor

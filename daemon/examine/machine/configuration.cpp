#include "daemon/examine/machine/machine.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include "daemon/ovwsd/settings/config_check.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/shared/shell_word.hpp"

namespace ovws::examine {
namespace {

std::string fix_of(const ConfigurationFacts& facts, const Error& error) {
  const auto dot = error.field.rfind('.');
  const std::string key = error.field.substr(dot == std::string::npos ? 0 : dot + 1);
  if (!error.nearest.empty()) {
    return fmt::format("in {}: \"{}\" in place of \"{}\"", facts.path, error.nearest, key);
  }
  const bool is_unreadable = error.field.empty() && error.code == Errc::unavailable;
  return (is_unreadable ? "namei -l " : "sudoedit ") +  // each folder with its permissions
         shell_word(facts.path.empty() ? kServicePath : facts.path);
}

Finding judge_configuration(const ConfigurationFacts& facts) {
  if (facts.error) {
    return bad("a daemon does not start with this configuration: " + text_of(*facts.error),
               fix_of(facts, *facts.error));
  }
  if (const auto& keys = facts.keys; keys.error) {
    return bad("a daemon does not start with this configuration: " + text_of(*keys.error),
               keys.fix.empty() ? fix_of(facts, *keys.error) : keys.fix);
  }
  if (facts.unseen) {
    return bad("the sensor cannot measure with this configuration: " + text_of(*facts.unseen),
               fix_of(facts, *facts.unseen));
  }
  const std::string in_use = "the settings that the daemon at " + facts.daemon + " uses";
  if (facts.path.empty() && !facts.daemon.empty()) return good("the checks judge " + in_use);
  if (facts.path.empty()) {
    return warning(fmt::format("no file is named and {} does not exist: the checks use the "
                               "defaults, which are the demonstration's",
                               kServicePath),
                   "ovws doctor --config FILE");
  }
  const std::string valid =
      facts.path + " is valid" + (facts.daemon.empty() ? "" : ", and the checks judge " + in_use);
  if (facts.saved_is_unused) {
    return warning(valid + "; " + facts.saved, "ovws call config.save");
  }
  if (!facts.rejected.empty()) {
    return warning(valid + "; the file of saved settings could not be used and was renamed to " +
                       facts.rejected +
                       ": set the missing ones again, save them with config.save, and remove "
                       "that file",
                   "sudo rm " + shell_word(facts.rejected));
  }
  if (!facts.keys.read) {
    return not_here(
        valid + "; the daemon's secret key was not checked, because this user cannot read it",
        "sudo -u " + facts.keys.user + " ovws doctor --config " + shell_word(facts.path));
  }
  return good(facts.saved.empty() ? valid : valid + "; " + facts.saved);
}

Finding judge_zeroth_order(const ConfigurationFacts& facts) {
  const bool is_unusable = facts.daemon.empty() && facts.error;
  if (!facts.config || is_unusable || facts.unseen) {
    return not_here("the configuration describes no usable sensor");
  }
  if (facts.config->modulator == Modulator::fixed) {
    return not_here("a fixed array of lenslets has no zeroth order");
  }
  if (!facts.zeroth_order) {
    return good("the SLM's zeroth order is outside camera.roi and far from the spots");
  }
  return warning(text_of(*facts.zeroth_order),
                 facts.daemon.empty() ? fix_of(facts, *facts.zeroth_order) : "ovws setup spot");
}

}  // namespace

ConfigurationFacts read_configuration(const std::string& path) {
  ConfigurationFacts facts;
  facts.path = path;
  if (path.empty() && ::access(kServicePath, F_OK) == 0) facts.path = kServicePath;
  const auto loaded = load_with_saved(facts.path, service_state_folder(facts.path));
  if (!loaded) {
    facts.error = loaded.error();
    return facts;
  }
  const Config& config = loaded->effective;
  facts.config = config;
  facts.saved = describe_saved(*loaded);
  facts.rejected = loaded->rejected;
  facts.saved_is_unused = !loaded->unused_reason.empty();
  if (const auto usable = check_usable(config); !usable) facts.error = usable.error();
  if (const auto seen = check_sees_spots(config); !seen) facts.unseen = seen.error();
  if (const auto dark = check_zeroth_order(config); !dark) facts.zeroth_order = dark.error();
  facts.keys = check_key_files(facts.path, config);
  return facts;
}

void judge_instead(ConfigurationFacts& facts, const Config& in_use, const std::string& endpoint) {
  facts.config = in_use;
  facts.daemon = endpoint;
  facts.unseen.reset();
  facts.zeroth_order.reset();
  if (const auto dark = check_zeroth_order(in_use); !dark) facts.zeroth_order = dark.error();
}

Findings answers(const ConfigurationFacts& facts) {
  constexpr Question<ConfigurationFacts> kQuestions[] = {
      {"configuration", judge_configuration},
      {"optics.zeroth_order", judge_zeroth_order},
  };
  return answers<ConfigurationFacts>(kQuestions, facts);
}

}  // namespace ovws::examine

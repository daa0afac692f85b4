/// ovws setup: the commissioning as a conversation on a terminal.
#pragma once

#include <string>
#include <vector>

#include "daemon/examine/finding.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::cli {

struct SetupOptions {
  std::vector<std::string> steps;  ///< run these only; empty: all from the first that is not done
  std::string from;                ///< begin with this step, even if it is done; empty: no
  std::string folder;              ///< for the pictures as PNG files; empty: they are not written
  std::string config_path;         ///< for the checks of this machine; empty: the service's
  std::string endpoint;            ///< for the same checks; empty: that of the configuration
  bool yes = false;                ///< no questions: take each step's proposal
  bool list = false;               ///< only list the steps and their states
};

/// Returns kOk if every step that it came to is done or skipped, also if the user quits then;
/// kError if one has failed; kNoDaemon if no daemon answers.
int set_up(const Common& common, const SetupOptions& options);

/// The checks of `ovws doctor`; takes some seconds.
examine::Findings examine_bench(const Common& common, const std::string& config_path,
                                const std::string& endpoint);

}  // namespace ovws::cli

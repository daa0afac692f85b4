#include <CLI/CLI.hpp>
#include <memory>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

void add_check(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "check",
      "measure how good the bench is, and say what to improve first: response to 0.1 wave of each "
      "mode, noise, vibration, drift, settle time, look-up table, closed loop; takes about two "
      "minutes");
  command->footer(
      "Needs a reference. Restores the aberration, the loop, its correction and the look-up "
      "table,\n"
      "also after Ctrl-C or an error.\n\n"
      "Exit codes: 0 no verdict is bad; 1 one is, or the check failed; 2 the command line is\n"
      "wrong; 3 no daemon answered in time.");
  auto options = std::make_shared<AcceptanceOptions>();
  command->add_option("--output,-o", options->output,
                      "write the report as one HTML file with figures, e.g. report.html");
  command->add_option("--seconds", options->seconds, "time for noise and drift, s")
      ->capture_default_str()
      ->check(number_from(2.0, 3600.0));
  command->add_flag("--quick", options->quick,
                    "half a minute: fewer frames, at most 10 s for noise and drift, no measurement "
                    "of the look-up table");
  command->add_flag("--open-loop", options->open_loop,
                    "open a closed loop, and close it again at the end");
  command->add_flag("--no-loop", options->no_loop, "do not close the loop");
  command->callback([&common, &status, options] { status = check_acceptance(common, *options); });
}

}  // namespace ovws::cli

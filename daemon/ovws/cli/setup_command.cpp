#include <CLI/CLI.hpp>
#include <memory>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/setup.hpp"

namespace ovws::cli {

void add_setup(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand(
      "setup",
      "commission the bench step by step, from the first check to a closed loop, by questions on "
      "the terminal; begins at the first step that is not known as done");
  command->footer(
      "Each step says what it found and what to do. Keys: Enter runs the step, goes on, or takes\n"
      "the proposal of a step that has failed; s skips, u undoes, r repeats, a number takes an\n"
      "offer, q quits, ? shows help. Nothing is lost by quitting: results are in use on the\n"
      "daemon at once, and the last step saves the settings.\n\n"
      "Exit codes: 0 no step has failed; 1 a step has failed; 2 the command line is wrong; 3 no\n"
      "daemon answered in time.");
  auto options = std::make_shared<SetupOptions>();
  command->add_option("steps", options->steps, "names of steps to run (default: all)");
  command->add_option("--from", options->from, "name of the step to begin with, done or not");
  command->add_flag("--yes,-y", options->yes,
                    "no questions: run every step that is not done, and take the proposals of "
                    "those that fail");
  command->add_flag("--list", options->list, "list the steps and their states only");
  command->add_option("--output,-o", options->folder,
                      "folder for the steps' pictures as PNG files");
  command->add_option("--config,-c", options->config_path,
                      "configuration file for the checks of this machine (default: the settings "
                      "that the daemon uses)");
  const CLI::Option* const given = app.get_option("--endpoint");
  command->callback([&common, &status, options, given] {
    if (given->count() > 0) options->endpoint = common.endpoint;
    status = set_up(common, *options);
  });
}

}  // namespace ovws::cli

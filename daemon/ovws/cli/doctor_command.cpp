#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

void add_doctor(CLI::App& app, const Common& common, int& status) {
  auto* command = app.add_subcommand("doctor",
                                     "check this bench in a few seconds and print a fix for each "
                                     "problem; read-only, works with or "
                                     "without a daemon, needs no root");
  command->footer(
      "Checks the configuration, the camera and its link, the SLM's output, the state folder,\n"
      "the real-time limits and the clock of this machine, and the daemon if one is running.\n"
      "It judges the settings that the daemon uses, or a file; \"configuration\" says which.\n"
      "Run it as the daemon's user, on its display:\n"
      "  sudo -u ovws DISPLAY=:0 XAUTHORITY=/var/lib/ovws/xauthority ovws doctor\n\n"
      "Each finding is FAULT (does not work, or measures wrongly), warning (works or may work, "
      "but\n"
      "worse than it could), ok, or not here (cannot be checked, with the reason). \"fix:\" is "
      "followed\n"
      "by a shell command or a line for the configuration file.\n"
      "--json prints one document: {\"schema\", \"version\", \"counts\": {\"fault\", …}, "
      "\"findings\":\n"
      "[{\"name\", \"verdict\": \"fault\" | \"warning\" | \"ok\" | \"not_here\", \"meaning\", "
      "\"fix\"}]}.\n\n"
      "Exit codes: 0 no fault; 1 at least one fault; 2 the command line is wrong.");
  auto path = std::make_shared<std::string>();
  command->add_option(
      "--config,-c", *path,
      "configuration file to judge (default: the settings that the daemon on this machine uses; if "
      "none answers, /etc/ovws/ovwsd.json; if there is none, every key's default)");
  const CLI::Option* const given = app.get_option("--endpoint");
  command->callback([&common, &status, path, given] {
    status = check_bench(common, *path, given->count() > 0 ? common.endpoint : "");
  });
}

}  // namespace ovws::cli

/// ovws keygen: makes a CURVE key pair for a daemon or a client.
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/shared/key_file.hpp"

namespace ovws::cli {
namespace {

struct KeygenOptions {
  std::string output;
  bool replace = false;
};

int make_keys(const Common& common, const KeygenOptions& options) {
  const auto pair = make_key_pair();
  if (!pair) return report(common, pair.error());
  if (!common.server_key.empty() && !is_curve_key(common.server_key)) {
    return report(common, {Errc::invalid, "--server-key", "is not a key of 40 characters"});
  }
  const KeyFile keys{*pair, common.server_key};
  if (auto written = write_key_file(options.output, keys, options.replace); !written) {
    return report(common, written.error());
  }
  return print_result(common, {{"file", options.output}, {"public_key", pair->public_key}},
                      pair->public_key);
}

}  // namespace

void add_keygen(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "keygen",
      "make a key pair for a daemon or a client, write it to a file that only you can read, and "
      "print the public key; --server-key stores the daemon's public key in the same file; works "
      "offline",
      make_keys);
  command.add_option("--output,-o", options.output, "JSON file to write")
      ->required()
      ->check([](const std::string& path) { return path.empty() ? "it is empty" : ""; });
  command.add_flag("--replace", options.replace, "replace an existing file, and keep its owner");
}

}  // namespace ovws::cli

/// ovws keygen: makes a CURVE key pair for a daemon or a client.
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/shared/key_file.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
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
  if (common.json) {
    print("{}\n",
          json_text(nlohmann::json{{"file", options.output}, {"public_key", pair->public_key}}));
  } else {
    print("{}\n", pair->public_key);
  }
  return kOk;
}

}  // namespace ovws::cli

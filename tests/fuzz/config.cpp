/// Whatever bytes a configuration file holds: an error that says where, or a configuration that is
/// written and read again as the same.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "config/config.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = ovws::parse_config({reinterpret_cast<const char*>(data), size});
  if (!read) {
    if (read.error().reason.empty()) std::abort();
    return 0;
  }
  const std::string written = ovws::dump_config(*read);
  const auto again = ovws::parse_config(written);
  if (!again || ovws::dump_config(*again) != written) std::abort();
  return 0;
}

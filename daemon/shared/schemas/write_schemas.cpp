/// write_schemas FOLDER MODE_NAMES: writes every JSON Schema to FOLDER/NAME.json, and the common
/// names of the Zernike modes, from j = 0 on, to the file MODE_NAMES.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/optics/zernike.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "proto/json_text.hpp"

namespace {

nlohmann::json mode_names() {
  nlohmann::json names = nlohmann::json::array();
  for (int j = 0; ovws::zernike_name(j).find('(') == std::string::npos; ++j) {
    names.push_back(ovws::zernike_name(j));
  }
  return names;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: write_schemas FOLDER MODE_NAMES\n", stderr);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  for (const ovws::Schema& schema : ovws::schemas()) {
    std::ofstream file(folder / (schema.name + ".json"));
    file << ovws::json_text(schema.json, 2) << "\n";
    if (!file.flush()) return 1;
  }
  std::ofstream names(argv[2]);
  names << ovws::json_text(mode_names(), 2) << "\n";
  return names.flush() ? 0 : 1;
}

/// write_schemas FOLDER: writes every JSON Schema to FOLDER/NAME.json.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "daemon/shared/schemas/schemas.hpp"
#include "proto/json_text.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_schemas FOLDER\n", stderr);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  for (const ovws::Schema& schema : ovws::schemas()) {
    std::ofstream file(folder / (schema.name + ".json"));
    file << ovws::json_text(schema.json, 2) << "\n";
    if (!file.flush()) return 1;
  }
  return 0;
}

#include "daemon/shared/schemas/schemas.hpp"

#include <algorithm>
#include <cctype>

#include "config/tables.hpp"
#include "proto/field_schema.hpp"
#include "proto/json_text.hpp"
#include "proto/method_list.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/devices.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/lattices.hpp"
#include "proto/tables/picture.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/status.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {

/// Text of daemon/shared/schemas/examples.json:
/// {params: {METHOD: [...]}, results: {TABLE: ...}, messages: {TOPIC: ...}}.
extern const std::string_view kExamples;

namespace {

/// Title of a method: "Camera: auto exposure" for "camera.auto_exposure".
std::string title_of(std::string name) {
  name[0] = char(std::toupper(name[0]));
  std::replace(name.begin(), name.end(), '_', ' ');
  if (const std::size_t dot = name.find('.'); dot != std::string::npos) name.replace(dot, 1, ": ");
  return name;
}

/// Name and text of a method, whatever its types.
struct MethodText {
  const char *name, *description, *binary_params, *binary_result, *result;
};

Schema schema_of_method(const MethodText& method, Json params, Json result, const Json& examples) {
  params["examples"] = examples["params"].value(method.name, Json::array({Json::object()}));
  if (const auto found = examples["results"].find(method.result);
      found != examples["results"].end()) {
    result["examples"] = Json::array({*found});
  }
  Json json{{"title", title_of(method.name)},
            {"description", method.description},
            {"params", std::move(params)},
            {"result", std::move(result)}};
  if (method.binary_params != nullptr) json["binary_params"] = method.binary_params;
  if (method.binary_result != nullptr) json["binary_result"] = method.binary_result;
  return {method.name, std::move(json)};
}

Schema schema_of_stream(const char* topic, const char* description, Json message,
                        const Json& examples) {
  message["title"] = title_of(topic);
  message["description"] = description;
  message["examples"] = Json::array({examples["messages"].at(topic)});
  return {std::string("stream.") + topic, std::move(message)};
}

std::vector<Schema> make_schemas() {
  const Json examples = json_of(kExamples);
  std::vector<Schema> all;
  const auto put_method = [&]<class P, class R>(const Method<P, R>& m) {
    all.push_back(
        schema_of_method({m.name, m.description, m.binary_params, m.binary_result, kTable<R>.name},
                         schema_of<P>(SchemaOf::params), schema_of<R>(SchemaOf::result), examples));
  };
  const auto put_stream = [&]<class M>(const Stream<M>& stream) {
    all.push_back(schema_of_stream(stream.topic, stream.description, schema_of<M>(SchemaOf::result),
                                   examples));
  };
  kMethods.apply([&](const auto&... method) { (put_method(method), ...); });
  kStreams.apply([&](const auto&... stream) { (put_stream(stream), ...); });
  std::sort(all.begin(), all.end(),
            [](const Schema& a, const Schema& b) { return a.name < b.name; });
  return all;
}

}  // namespace

const std::vector<Schema>& schemas() {
  static const std::vector<Schema> kAll = make_schemas();
  return kAll;
}

const nlohmann::json& schema(std::string_view name) {
  static const Json kNone;
  for (const Schema& one : schemas()) {
    if (one.name == name) return one.json;
  }
  return kNone;
}

}  // namespace ovws

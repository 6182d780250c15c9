// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh_request.h"
#include <nlohmann/json.hpp>

namespace signorini::mesh {

using nlohmann::json;

std::string packed(const GmshRequest& request) {
  const scene::Mesh& mesh = request.mesh;
  json all{{"file", mesh.file.string()}, {"scale", mesh.scale},   {"unit", static_cast<int>(mesh.unit)},
           {"split", mesh.split},        {"degree", mesh.degree}, {"keep", request.keep.string()}};
  if (mesh.size)
    all["size"] = *mesh.size;
  if (const auto& field = request.sizes)
    all["sizes"] = {
        {"dim", field->dim}, {"points", field->points}, {"cells", field->cells}, {"sizes", field->sizes}};
  const auto put = [&](const char* key, const std::string& bytes) {
    all[key] = json::binary(std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
  };
  if (request.msh)
    put("msh", *request.msh);
  if (request.written)
    put("written", packed(*request.written));
  std::string bytes;
  json::to_cbor(all, bytes);
  return bytes;
}

GmshRequest request_of(const std::string& bytes) {
  const json all = json::from_cbor(bytes);
  GmshRequest request{.mesh{.file = all.at("file").get<std::string>(),
                            .size{},
                            .scale = all.at("scale"),
                            .unit = static_cast<scene::LengthUnit>(all.at("unit").get<int>()),
                            .split = all.at("split"),
                            .degree = all.at("degree")}};
  request.keep = all.at("keep").get<std::string>();
  if (const auto size = all.find("size"); size != all.end())
    request.mesh.size = size->get<double>();
  if (const auto field = all.find("sizes"); field != all.end())
    request.sizes = {.dim = field->at("dim"),
                     .points = field->at("points"),
                     .cells = field->at("cells"),
                     .sizes = field->at("sizes")};
  const auto bytes_of = [&](const char* key) -> std::optional<std::string_view> {
    const auto found = all.find(key);
    if (found == all.end())
      return std::nullopt;
    const auto& raw = found->get_binary();
    return std::string_view(reinterpret_cast<const char*>(raw.data()), raw.size());
  };
  if (const auto msh = bytes_of("msh"))
    request.msh = *msh;
  if (const auto written = bytes_of("written"))
    request.written = unpacked(*written);
  return request;
}

} // namespace signorini::mesh

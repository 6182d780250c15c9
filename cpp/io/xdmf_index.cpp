// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/xdmf_index.h"
#include <fmt/format.h>
#include <iterator>

namespace signorini::io {
namespace {

const char* attribute_type(Values values) {
  switch (values) {
  case Values::nodal:
  case Values::cellwise:
    return "Vector";
  case Values::cellwise_tensor:
    return "Tensor";
  default:
    return "Scalar";
  }
}

} // namespace

std::string numbered(std::size_t number) { return fmt::format("{:08}", number); }

XdmfIndex::XdmfIndex(std::string data, int dim, std::size_t nodes, std::size_t cells)
    : data_(std::move(data)), dim_(dim), nodes_(nodes), cells_(cells) {}

std::string XdmfIndex::begin() const {
  return fmt::format(R"xml(<?xml version="1.0"?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="3.0" xmlns:xi="https://www.w3.org/2001/XInclude">
  <Domain>
    <Grid Name="mesh" GridType="Uniform">
      <Topology TopologyType="{0}" NumberOfElements="{1}" NodesPerElement="{2}">
        <DataItem Dimensions="{1} {2}" NumberType="Int" Format="HDF">{3}:/Mesh/mesh/topology</DataItem>
      </Topology>
      <Geometry GeometryType="{4}">
        <DataItem Dimensions="{5} {6}" Format="HDF">{3}:/Mesh/mesh/geometry</DataItem>
      </Geometry>
    </Grid>
)xml",
                     dim_ == 3 ? "Tetrahedron" : "Triangle", cells_, dim_ + 1, data_,
                     dim_ == 3 ? "XYZ" : "XY", nodes_, dim_);
}

std::string XdmfIndex::field(const std::string& name, Values values, const std::vector<double>& times) const {
  std::string text =
      fmt::format("    <Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n", name);
  for (std::size_t i = 0; i < times.size(); ++i)
    fmt::format_to(std::back_inserter(text), R"xml(      <Grid Name="{0}" GridType="Uniform">
        <xi:include xpointer="xpointer(/Xdmf/Domain/Grid[@GridType='Uniform'][1]/*[self::Topology or self::Geometry])" />
        <Time Value="{1}" />
        <Attribute Name="{0}" AttributeType="{2}" Center="{3}">
          <DataItem Dimensions="{4} {5}" Format="HDF">{6}:/Function/{0}/{7}</DataItem>
        </Attribute>
      </Grid>
)xml",
                   name, times[i], attribute_type(values), in_cells(values) ? "Cell" : "Node",
                   in_cells(values) ? cells_ : nodes_, stored_components(values), data_, numbered(i));
  return text + "    </Grid>\n";
}

std::string XdmfIndex::end() { return "  </Domain>\n</Xdmf>\n"; }

} // namespace signorini::io

// SPDX-License-Identifier: BSD-3-Clause
#include "patch_plane_clustering/ros/triangulation.h"

#include <GL/glu.h>
#include <deque>
#include <memory>
#include <new>

namespace ppc {
namespace {

struct Tessellation {
  std::deque<Eigen::Vector3d> vertices;  // the tessellator keeps pointers to them: a deque does not move its elements
  std::vector<Eigen::Vector3d> triangles;
};

void APIENTRY onVertex(void* vertex, void* data) {
  static_cast<Tessellation*>(data)->triangles.push_back(*static_cast<Eigen::Vector3d*>(vertex));
}

// Asked for where rings touch.
void APIENTRY onCombine(GLdouble position[3], void* /*merged*/[4], GLfloat /*weights*/[4], void** made, void* data) {
  auto& vertices = static_cast<Tessellation*>(data)->vertices;
  vertices.emplace_back(position[0], position[1], position[2]);
  *made = &vertices.back();
}

// Its mere presence makes the tessellator return plain triangles, no strips or fans.
void APIENTRY onEdgeFlag(GLboolean /*boundary*/) {}

void addRing(GLUtesselator* tessellator, const std::vector<Eigen::Vector3d>& ring, Tessellation& tessellation) {
  gluTessBeginContour(tessellator);
  for (const Eigen::Vector3d& vertex : ring) {
    tessellation.vertices.push_back(vertex);
    Eigen::Vector3d& kept = tessellation.vertices.back();
    gluTessVertex(tessellator, kept.data(), &kept);
  }
  gluTessEndContour(tessellator);
}

}  // namespace

std::vector<Eigen::Vector3d> triangulate(const PlanarPolygon& polygon, const Eigen::Vector3d& normal) {
  const std::unique_ptr<GLUtesselator, void (*)(GLUtesselator*)> tessellator(gluNewTess(), &gluDeleteTess);
  if (!tessellator) throw std::bad_alloc();
  GLUtesselator* const tess = tessellator.get();
  gluTessCallback(tess, GLU_TESS_VERTEX_DATA, reinterpret_cast<_GLUfuncptr>(&onVertex));
  gluTessCallback(tess, GLU_TESS_COMBINE_DATA, reinterpret_cast<_GLUfuncptr>(&onCombine));
  gluTessCallback(tess, GLU_TESS_EDGE_FLAG, reinterpret_cast<_GLUfuncptr>(&onEdgeFlag));
  gluTessProperty(tess, GLU_TESS_WINDING_RULE, GLU_TESS_WINDING_ODD);
  gluTessNormal(tess, normal.x(), normal.y(), normal.z());

  Tessellation tessellation;
  gluTessBeginPolygon(tess, &tessellation);
  addRing(tess, polygon.outer, tessellation);
  for (const auto& hole : polygon.holes) addRing(tess, hole, tessellation);
  gluTessEndPolygon(tess);
  tessellation.triangles.resize(tessellation.triangles.size() / 3 * 3);  // an error may leave a triangle unfinished
  return tessellation.triangles;
}

}  // namespace ppc

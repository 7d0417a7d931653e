#include "RoughMesh.h"

namespace isofront::extractor {

void RoughMesh::compact()
{
    _renamed.assign(vertices.size(), kNoVertex);
    _kept.clear();
    _kept.reserve(vertices.size());
    for (std::uint16_t& index : indices) {
        if (_renamed[index] == kNoVertex) {
            _renamed[index] = static_cast<std::uint16_t>(_kept.size());
            _kept.push_back(vertices[index]);
        }
        index = _renamed[index];
    }
    vertices.swap(_kept);
}

} // namespace isofront::extractor

#include "TriangleShape.h"

#include <algorithm>
#include <limits>

namespace isofront::extractor {

double
squaredDistance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    const glm::dvec3 ab = b - a;
    const glm::dvec3 bc = c - b;
    const glm::dvec3 ca = a - c;
    const glm::dvec3 normal = glm::cross(ab, c - a);
    const bool besideAb = glm::dot(glm::cross(ab, p - a), normal) < 0;
    const bool besideBc = glm::dot(glm::cross(bc, p - b), normal) < 0;
    const bool besideCa = glm::dot(glm::cross(ca, p - c), normal) < 0;
    if (!besideAb && !besideBc && !besideCa) {
        const double height = glm::dot(p - a, normal);
        return height * height / glm::dot(normal, normal);
    }
    const auto toSide = [&](const glm::dvec3& from, const glm::dvec3& along) {
        const glm::dvec3 d = p - from;
        const double t = std::clamp(glm::dot(d, along) / glm::dot(along, along), 0.0, 1.0);
        const glm::dvec3 rest = d - t * along;
        return glm::dot(rest, rest);
    };
    // the nearest side is one that the point lies beside
    double least = std::numeric_limits<double>::infinity();
    if (besideAb)
        least = toSide(a, ab);
    if (besideBc)
        least = std::min(least, toSide(b, bc));
    if (besideCa)
        least = std::min(least, toSide(c, ca));
    return least;
}

} // namespace isofront::extractor

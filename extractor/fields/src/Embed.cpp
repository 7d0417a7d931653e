#include "isofront/fields/Embed.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Powers.h>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace isofront::fields {

namespace {

class Embedded final : public Field {
public:
    Embedded(std::shared_ptr<const Field> field, const Embedding& embedding)
        : _field(std::move(field)), _embedding(embedding), _inwards(embedding.place.inverse()),
          _gradients(embedding.place.normalMatrix()),
          _scale(core::cubeRoot(std::abs(glm::determinant(embedding.place.linear)))),
          _box(_field->dataBox())
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        const Points points(*this, batch);
        _field->sample(points.batch(), values);
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<float>(
                std::min(double(values[i]) - _embedding.isovalue, wallAt(points.at(i)).value));
    }

    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        const Points points(*this, batch);
        std::vector<float> values(batch.size());
        _field->sampleWithGradient(points.batch(), values, gradients);
        for (std::size_t i = 0; i < values.size(); ++i) {
            glm::dvec3 own(gradients.x[i], gradients.y[i], gradients.z[i]);
            const Wall wall = wallAt(points.at(i));
            if (wall.value < double(values[i]) - _embedding.isovalue)
                own = wall.gradient;
            const glm::dvec3 turned = _gradients * own;
            gradients.x[i] = turned.x;
            gradients.y[i] = turned.y;
            gradients.z[i] = turned.z;
        }
    }

    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        if (box.isEmpty())
            return {};
        core::Box own;
        for (unsigned corner = 0; corner < 8; ++corner)
            own.include(_inwards.point(
                {(corner & 1U) != 0 ? box.high.x : box.low.x,
                 (corner & 2U) != 0 ? box.high.y : box.low.y,
                 (corner & 4U) != 0 ? box.high.z : box.low.z}));
        // For what rounding does to points on their way.
        const glm::dvec3 far = glm::max(glm::abs(box.low), glm::abs(box.high));
        glm::dvec3 slack = glm::abs(_inwards.translation);
        for (glm::length_t column = 0; column < 3; ++column)
            slack += glm::abs(_inwards.linear[column]) * far[column];
        own = {own.low - 1e-14 * slack, own.high + 1e-14 * slack};
        core::Interval values = _field->bounds(
            own, {radius.low / _scale * (1 - 1e-12), radius.high / _scale * (1 + 1e-12)});
        values = {values.low - _embedding.isovalue, values.high - _embedding.isovalue};
        if (_box) {
            core::Interval wall{values.low, values.high};
            for (glm::length_t axis = 0; axis < 3; ++axis) {
                const double fromLow = _embedding.sharpness * (own.low[axis] - _box->low[axis]);
                const double fromHigh = _embedding.sharpness * (_box->high[axis] - own.high[axis]);
                const double edge = _embedding.sharpness * (own.high[axis] - own.low[axis]);
                wall.low = std::min({wall.low, fromLow, fromHigh});
                wall.high = std::min({wall.high, fromLow + edge, fromHigh + edge});
            }
            values = wall;
        }
        constexpr double kUlps = 2.4e-7;
        return {
            values.low - kUlps * std::abs(values.low), values.high + kUlps * std::abs(values.high)};
    }

    double differenceStep(double radius) const override
    {
        return _scale * _field->differenceStep(radius / _scale);
    }

private:
    struct Wall {
        double value;
        glm::dvec3 gradient; ///< in the field's own space
    };

    /// The batch in the field's own space.
    class Points {
    public:
        Points(const Embedded& embedded, const SampleBatch& batch)
            : _x(batch.size()), _y(batch.size()), _z(batch.size()),
              _radius(batch.radius.begin(), batch.radius.end())
        {
            for (std::size_t i = 0; i < batch.size(); ++i) {
                const glm::dvec3 p = embedded._inwards.point({batch.x[i], batch.y[i], batch.z[i]});
                _x[i] = p.x;
                _y[i] = p.y;
                _z[i] = p.z;
            }
            for (double& radius : _radius)
                radius /= embedded._scale;
        }
        [[nodiscard]] SampleBatch batch() const { return {_x, _y, _z, _radius}; }
        [[nodiscard]] glm::dvec3 at(std::size_t i) const { return {_x[i], _y[i], _z[i]}; }

    private:
        std::vector<double> _x;
        std::vector<double> _y;
        std::vector<double> _z;
        std::vector<double> _radius;
    };

    /// What the nearest side of the data box says.
    [[nodiscard]] Wall wallAt(const glm::dvec3& p) const
    {
        Wall wall{std::numeric_limits<double>::infinity(), glm::dvec3(0)};
        if (!_box)
            return wall;
        const auto see = [&](double distance, glm::length_t axis, double sign) {
            const double value = _embedding.sharpness * distance;
            if (!(value < wall.value))
                return;
            wall = {value, glm::dvec3(0)};
            wall.gradient[axis] = sign * _embedding.sharpness;
        };
        for (glm::length_t axis = 0; axis < 3; ++axis) {
            see(p[axis] - _box->low[axis], axis, 1);
            see(_box->high[axis] - p[axis], axis, -1);
        }
        return wall;
    }

    std::shared_ptr<const Field> _field;
    Embedding _embedding;
    core::Affine _inwards;
    glm::dmat3 _gradients;
    double _scale;
    std::optional<core::Box> _box; ///< of the data, in the field's own space
};

} // namespace

std::shared_ptr<const Field>
embedded(std::shared_ptr<const Field> field, const Embedding& embedding)
{
    ISOFRONT_ASSERT(
        glm::determinant(embedding.place.linear) != 0, "an embedding needs a map with an inverse");
    ISOFRONT_ASSERT(embedding.sharpness >= 0, "a border that grows outwards is none");
    return std::make_shared<Embedded>(std::move(field), embedding);
}

} // namespace isofront::fields

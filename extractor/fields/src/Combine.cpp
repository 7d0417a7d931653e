#include "isofront/fields/Combine.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace isofront::fields {

namespace {

enum class Operation { unite, intersect, subtract };

class Combined final : public Field {
public:
    Combined(
        Operation operation,
        std::shared_ptr<const Field> first,
        std::shared_ptr<const Field> second)
        : _operation(operation), _first(std::move(first)), _second(std::move(second))
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        std::vector<float> other(batch.size());
        _first->sample(batch, values);
        _second->sample(batch, other);
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = takesFirst(values[i], other[i]) ? values[i] : turned(other[i]);
    }

    void sampleGrid(const SampleGrid& grid, std::span<float> values) const override
    {
        std::vector<float> other(grid.size());
        _first->sampleGrid(grid, values);
        _second->sampleGrid(grid, other);
        for (std::size_t i = 0; i < other.size(); ++i)
            values[i] = takesFirst(values[i], other[i]) ? values[i] : turned(other[i]);
    }

    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        const std::size_t size = batch.size();
        std::vector<float> first(size);
        std::vector<float> second(size);
        std::vector<double> x(size);
        std::vector<double> y(size);
        std::vector<double> z(size);
        _first->sample(batch, first);
        _second->sample(batch, second);
        _first->gradient(batch, gradients);
        _second->gradient(batch, {x, y, z});
        for (std::size_t i = 0; i < size; ++i) {
            if (takesFirst(first[i], second[i]))
                continue;
            gradients.x[i] = turned(x[i]);
            gradients.y[i] = turned(y[i]);
            gradients.z[i] = turned(z[i]);
        }
    }

    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        const core::Interval a = _first->bounds(box, radius);
        core::Interval b = _second->bounds(box, radius);
        if (_operation == Operation::subtract)
            b = {-b.high, -b.low};
        if (_operation == Operation::unite)
            return {std::max(a.low, b.low), std::max(a.high, b.high)};
        return {std::min(a.low, b.low), std::min(a.high, b.high)};
    }

    double differenceStep(double radius) const override
    {
        return std::min(_first->differenceStep(radius), _second->differenceStep(radius));
    }

private:
    template <typename T>
    [[nodiscard]] T turned(T value) const
    {
        return _operation == Operation::subtract ? -value : value;
    }
    [[nodiscard]] bool takesFirst(float first, float second) const
    {
        return _operation == Operation::unite ? first >= second : first <= turned(second);
    }

    Operation _operation;
    std::shared_ptr<const Field> _first;
    std::shared_ptr<const Field> _second;
};

class Placed final : public Field {
public:
    Placed(std::shared_ptr<const Field> field, const glm::dvec3& translation, double scale)
        : _field(std::move(field)), _translation(translation), _scale(scale)
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        const Scratch scratch(*this, batch);
        _field->sample(scratch.batch(), values);
        for (float& value : values)
            value = static_cast<float>(double(value) * _scale);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        // Value and lengths are scaled alike: the slope stays.
        _field->gradient(Scratch(*this, batch).batch(), gradients);
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        // A little larger than the box, for what rounding does to the points.
        const glm::dvec3 slack =
            1e-14 * (glm::max(glm::abs(box.low), glm::abs(box.high)) + glm::abs(_translation));
        const core::Interval inner = _field->bounds(
            {(box.low - slack - _translation) / _scale, (box.high + slack - _translation) / _scale},
            {radius.low / _scale, radius.high / _scale});
        const double ulp = 1.2e-7;
        return {
            inner.low * _scale - ulp * std::abs(inner.low * _scale),
            inner.high * _scale + ulp * std::abs(inner.high * _scale)};
    }
    double differenceStep(double radius) const override
    {
        return _scale * _field->differenceStep(radius / _scale);
    }
    std::optional<core::Box> dataBox() const override
    {
        const std::optional<core::Box> inner = _field->dataBox();
        if (!inner)
            return inner;
        return core::Box{inner->low * _scale + _translation, inner->high * _scale + _translation};
    }

private:
    class Scratch {
    public:
        Scratch(const Placed& placed, const SampleBatch& batch)
            : _x(batch.x.begin(), batch.x.end()), _y(batch.y.begin(), batch.y.end()),
              _z(batch.z.begin(), batch.z.end()), _radius(batch.radius.begin(), batch.radius.end())
        {
            for (double& x : _x)
                x = (x - placed._translation.x) / placed._scale;
            for (double& y : _y)
                y = (y - placed._translation.y) / placed._scale;
            for (double& z : _z)
                z = (z - placed._translation.z) / placed._scale;
            for (double& radius : _radius)
                radius /= placed._scale;
        }
        [[nodiscard]] SampleBatch batch() const { return {_x, _y, _z, _radius}; }

    private:
        std::vector<double> _x;
        std::vector<double> _y;
        std::vector<double> _z;
        std::vector<double> _radius;
    };

    std::shared_ptr<const Field> _field;
    glm::dvec3 _translation;
    double _scale;
};

class ColouredByPlace final : public Field {
public:
    ColouredByPlace(std::shared_ptr<const Field> field, const core::Box& box)
        : _field(std::move(field)), _box(box)
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        _field->sample(batch, values);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        _field->gradient(batch, gradients);
    }
    void sampleWithGradient(
        const SampleBatch& batch, std::span<float> values, GradientSpans gradients) const override
    {
        _field->sampleWithGradient(batch, values, gradients);
    }
    void sampleGrid(const SampleGrid& grid, std::span<float> values) const override
    {
        _field->sampleGrid(grid, values);
    }
    bool hasAttributes() const override { return true; }
    void attributes(const SampleBatch& batch, std::span<std::uint32_t> words) const override
    {
        const auto shade = [&](std::size_t axis, double coordinate) {
            const double share = (coordinate - _box.low[axis]) / (_box.high[axis] - _box.low[axis]);
            return static_cast<std::uint32_t>(255 * std::clamp(share, 0.0, 1.0) + 0.5);
        };
        for (std::size_t i = 0; i < batch.size(); ++i)
            words[i] =
                shade(0, batch.x[i]) | shade(1, batch.y[i]) << 8U | shade(2, batch.z[i]) << 16U;
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return _field->bounds(box, radius);
    }
    double differenceStep(double radius) const override { return _field->differenceStep(radius); }
    std::optional<core::Box> dataBox() const override { return _field->dataBox(); }

private:
    std::shared_ptr<const Field> _field;
    core::Box _box;
};

std::shared_ptr<const Field> combined(
    Operation operation, std::shared_ptr<const Field> first, std::shared_ptr<const Field> second)
{
    return std::make_shared<Combined>(operation, std::move(first), std::move(second));
}

} // namespace

std::shared_ptr<const Field>
unionOf(std::shared_ptr<const Field> first, std::shared_ptr<const Field> second)
{
    return combined(Operation::unite, std::move(first), std::move(second));
}

std::shared_ptr<const Field>
intersectionOf(std::shared_ptr<const Field> first, std::shared_ptr<const Field> second)
{
    return combined(Operation::intersect, std::move(first), std::move(second));
}

std::shared_ptr<const Field>
differenceOf(std::shared_ptr<const Field> first, std::shared_ptr<const Field> second)
{
    return combined(Operation::subtract, std::move(first), std::move(second));
}

std::shared_ptr<const Field>
placed(std::shared_ptr<const Field> field, const glm::dvec3& translation, double scale)
{
    ISOFRONT_ASSERT(scale > 0, "a scale must be above zero");
    return std::make_shared<Placed>(std::move(field), translation, scale);
}

std::shared_ptr<const Field>
colouredByPlace(std::shared_ptr<const Field> field, const core::Box& box)
{
    ISOFRONT_ASSERT(
        box.high.x > box.low.x && box.high.y > box.low.y && box.high.z > box.low.z,
        "colours need a box of positive size");
    return std::make_shared<ColouredByPlace>(std::move(field), box);
}

} // namespace isofront::fields

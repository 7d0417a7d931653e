#include "isofront/surface/Surface.h"

#include "LiveSurface.h"

#include <utility>

namespace isofront::surface {

Surface::Surface(
    std::shared_ptr<const fields::Field> field,
    hierarchy::Domain domain,
    SurfaceOptions options,
    std::shared_ptr<core::Jobs> jobs)
    : _impl(std::make_unique<Impl>(std::move(field), domain, options, std::move(jobs)))
{
}

Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;
Surface::~Surface() = default;

Delta Surface::update(const hierarchy::View& view, const UpdateBudget& budget)
{
    return _impl->update(view, budget);
}

Delta Surface::settle(
    const hierarchy::View& view,
    const std::function<void(double)>& progress,
    const std::stop_token& stop)
{
    return _impl->settle(view, progress, stop);
}

void Surface::setIsovalue(double isovalue)
{
    _impl->setIsovalue(isovalue);
}

double Surface::isovalue() const
{
    return _impl->isovalue();
}

void Surface::setDetail(double pixelError, DetailSettings detail)
{
    _impl->setDetail(pixelError, std::move(detail));
}

bool Surface::isSettled() const
{
    return _impl->isSettled();
}

SurfaceStats Surface::stats() const
{
    return _impl->stats();
}

const hierarchy::Domain& Surface::domain() const
{
    return _impl->domain();
}

} // namespace isofront::surface

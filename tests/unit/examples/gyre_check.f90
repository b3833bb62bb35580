!> Self-check of the gyre example: geometry, conservation, and the closed forms of the wind-driven
!! ocean: Ekman's transport and pumping, Sverdrup's balance, Stommel's boundary current.
program gyre_check
  use, intrinsic :: iso_fortran_env, only: error_unit, int32, output_unit, real64
  use gyre_basin, only: atlantic, box, earth_radius, radians
  use gyre_flow, only: fall
  use gyre_mesh, only: basin_mesh, mesh_type
  use gyre_model, only: day, drag, model_type
  use gyre_transport, only: transport_type
  use gyre_wind, only: beta, coriolis, density, ekman_pumping, wind_type
  implicit none

  integer :: failures = 0

  call check_mesh()
  call check_ekman()
  call check_waves()
  call check_box()
  call check_atlantic()
  if (failures > 0) error stop 1

contains

  !> Ids fit the arrays, cells are the right way around (depth counts downwards) and fill the basin.
  subroutine check_mesh()
    type(mesh_type) :: mesh
    real(real64) :: exact, area, u(3), v(3), normal
    integer :: c, boundary

    mesh = basin_mesh(box(-60.0_real64, -10.0_real64, 15.0_real64, 55.0_real64), 40, 30)
    call expect('ids start at 1', minval(mesh%connectivity) == 1_int32)
    call expect('ids end at the last vertex', maxval(mesh%connectivity) == size(mesh%lon))
    boundary = count(mesh%on_coast)
    call expect('Euler''s formula of a disc', &
                mesh%nv - (mesh%nedges + boundary) + mesh%ncolumns == 1)
    exact = earth_radius**2 * radians(50.0_real64) * (sin(radians(55.0_real64)) - sin(radians(15.0_real64)))
    area = sum(mesh%area)
    ! A triangle is taken at its centroid's latitude: second order, (4/3 degree)^2 / 24 here.
    call expect_near('area of the box', area, exact, 1.0e-4_real64 * exact)
    call expect_near('volume of the box', sum(mesh%volume), 5000.0_real64 * area, 1.0e-12_real64 * 5000.0_real64 * area)
    call expect('every volume is positive', minval(mesh%volume) > 0.0_real64)

    ! By VTK's rule the normal of a wedge's first triangle points away from its second one.
    mesh = basin_mesh(atlantic(), 16, 12)
    do c = 1, mesh%ncells()
      associate (id => mesh%connectivity(:, c))
        u = place(mesh, id(2)) - place(mesh, id(1))
        v = place(mesh, id(3)) - place(mesh, id(1))
        normal = u(1) * v(2) - u(2) * v(1)
        if (.not. (normal * (mesh%depth(id(1)) - mesh%depth(id(4))) > 0.0_real64)) then
          call expect('a wedge is the right way around', .false.)
          return
        end if
      end associate
    end do
    call expect('the Atlantic''s volumes are positive', minval(mesh%volume) > 0.0_real64)
    call expect('aspect ratios of 1e4', &
                maxval(norm2(mesh%edge_vector, dim=1)) / 5.0_real64 > 1.0e4_real64)
  end subroutine check_mesh

  pure function place(mesh, id)
    type(mesh_type), intent(in) :: mesh
    integer(int32), intent(in) :: id
    real(real64) :: place(3)
    place = [mesh%lon(id), mesh%lat(id), mesh%depth(id)]
  end function place

  !> The spiral solves i f u = nu u'' with the stress at the surface, by central differences (h^2), and
  !! carries stress / (density f) to the right of the wind.
  subroutine check_ekman()
    type(wind_type) :: wind
    complex(real64) :: u(3), residual, total
    real(real64), parameter :: h = 0.1_real64, lat = 34.0_real64, nu = 1.0e-2_real64
    real(real64) :: f, scale

    f = coriolis(lat)
    u = wind%ekman_velocity(lat, [10.0_real64 - h, 10.0_real64, 10.0_real64 + h])
    residual = nu * (u(1) - 2.0_real64 * u(2) + u(3)) / h**2 - cmplx(0.0_real64, f, real64) * u(2)
    call expect_near('the spiral''s equation', abs(residual), 0.0_real64, 1.0e-5_real64 * f * abs(u(2)))
    u = wind%ekman_velocity(lat, [0.0_real64, h, 2.0_real64 * h])
    scale = wind%eastward(lat) / (density * nu)
    residual = (3.0_real64 * u(1) - 4.0_real64 * u(2) + u(3)) / (2.0_real64 * h)
    call expect_near('the stress at the surface', abs(residual - scale), 0.0_real64, 1.0e-4_real64 * scale)
    total = wind%ekman_transport(lat, 0.0_real64)
    scale = wind%eastward(lat) / (density * f)
    call expect_near('to the right of the wind', abs(total + cmplx(0.0_real64, scale, real64)), 0.0_real64, &
                     1.0e-14_real64 * scale)
  end subroutine check_ekman

  !> Without wind and drag waves keep their energy, but for the extrapolation in time: of third order,
  !! so an eighth of the error at half the step.
  subroutine check_waves()
    real(real64) :: coarse, fine

    coarse = energy_error(0.25_real64 * day, 40)
    fine = energy_error(0.125_real64 * day, 80)
    write (output_unit, '(a, 2es9.1)') 'waves: change of energy in ten days, dt and dt/2:', coarse, fine
    call expect('waves keep their energy', abs(coarse) < 2.0e-2_real64)
    call expect('and better at a shorter step', abs(fine) < abs(coarse) / 6.0_real64)
  end subroutine check_waves

  real(real64) function energy_error(dt, steps) result(error)
    real(real64), intent(in) :: dt
    integer, intent(in) :: steps
    type(mesh_type) :: mesh
    type(transport_type) :: transport
    type(wind_type) :: wind
    real(real64) :: before
    integer :: i

    mesh = basin_mesh(atlantic(), 24, 18)
    call transport%start(mesh, wind, 0.0_real64)
    do i = 1, nint(10.0_real64 * day / dt)               ! stirred, then left alone
      call transport%step(mesh, dt, 1.0_real64)
    end do
    before = transport%energy(mesh)
    do i = 1, steps
      call transport%step(mesh, dt, 0.0_real64)
    end do
    error = transport%energy(mesh) / before - 1.0_real64
  end function energy_error

  !> The steady state of a flat box against theory.
  subroutine check_box()
    type(model_type) :: model
    real(real64) :: error, half_error
    integer :: i

    call model%start(box(-60.0_real64, -10.0_real64, 15.0_real64, 55.0_real64), 16)
    do i = 1, 400                                        ! 100 days: 13 times 1 / drag
      call model%transport%step(model%mesh, 0.25_real64 * day, 1.0_real64)
    end do
    call model%flow%update(model%mesh, model%transport%psi, 1.0_real64)
    call expect_near('no water is lost', model%flow%imbalance(model%mesh), 0.0_real64, 1.0e-13_real64)

    ! Sverdrup's transport is the limit without drag, whose torque is by theory of order drag / beta * x
    ! times the squared wave number of the wind: 0.10 where this looks. It is halved with the drag.
    error = sverdrup_error(model%mesh, model%transport%psi, model%wind)
    call check_pumping(model)
    call check_coastal_row(model)
    call check_boundary_current(model)
    call model%transport%start(model%mesh, model%wind, 0.5_real64 * drag)
    do i = 1, 800
      call model%transport%step(model%mesh, 0.25_real64 * day, 1.0_real64)
    end do
    half_error = sverdrup_error(model%mesh, model%transport%psi, model%wind)
    write (output_unit, '(a, 2f8.4)') 'Sverdrup: relative error with drag and half of it:', error, half_error
    call expect('Sverdrup''s balance', abs(error) < 0.1_real64)
    call expect('it comes nearer with less drag', abs(half_error) < 0.55_real64 * abs(error))
  end subroutine check_box

  !> Of the stream function 500 to 1000 km from the eastern coast, away from the walls in the south and
  !! the north: root mean square, against the integral of curl / (density beta) from that coast.
  real(real64) function sverdrup_error(mesh, psi, wind) result(error)
    type(mesh_type), intent(in) :: mesh
    real(real64), intent(in) :: psi(:)
    type(wind_type), intent(in) :: wind
    real(real64) :: width, exact, sum_error, sum_exact
    integer :: v

    sum_error = 0.0_real64
    sum_exact = 0.0_real64
    do v = 1, mesh%nv
      width = earth_radius * cos(radians(mesh%lat(v))) * radians(maxval(mesh%lon) - mesh%lon(v))
      if (width < 0.5e6_real64 .or. width > 1.0e6_real64) cycle
      if (abs(mesh%lat(v) - 35.0_real64) > 13.0_real64) cycle ! the walls' layers: sqrt(drag / beta * x)
      exact = -width * wind%curl(mesh%lat(v)) / (density * beta(mesh%lat(v)))
      sum_error = sum_error + (psi(v) - exact)**2
      sum_exact = sum_exact + exact**2
    end do
    error = sqrt(sum_error / sum_exact)
  end function sverdrup_error

  !> In the interior, over a flat bottom, the upward velocity under the spiral is Ekman's pumping less
  !! what has been used up by the columns above: it goes as the share of the mode below.
  subroutine check_pumping(model)
    type(model_type), intent(in) :: model
    real(real64) :: exact, worst, largest
    integer :: k, v, id

    worst = 0.0_real64
    largest = 0.0_real64
    do k = 2, model%mesh%nlevels
      if (model%mesh%interface_depth(1, k) < 100.0_real64) cycle
      do v = 1, model%mesh%nv
        if (abs(model%mesh%lon(v) + 35.0_real64) > 12.0_real64) cycle
        if (abs(model%mesh%lat(v) - 35.0_real64) > 15.0_real64) cycle
        id = v + (k - 1) * model%mesh%nv
        exact = ekman_pumping(model%wind, model%mesh%lat(v)) &
              * (exp(-model%mesh%depth(id) / fall) - exp(-5000.0_real64 / fall)) &
              / (1.0_real64 - exp(-5000.0_real64 / fall))
        worst = max(worst, abs(model%flow%velocity(3, id) - exact))
        largest = max(largest, abs(exact))
      end do
    end do
    write (output_unit, '(a, 2es10.2)') 'pumping: largest, and largest error (m/s):', largest, worst
    call expect('Ekman''s pumping', worst < 0.05_real64 * largest)
  end subroutine check_pumping

  !> The wind drives water off the southern coast; what rises for it rises at one speed in all cells of the
  !! row there, whether they have a side on the coast or a vertex alone: 60 m deep, far from the corners.
  subroutine check_coastal_row(model)
    type(model_type), intent(in) :: model
    real(real64) :: least, most, speed
    integer :: c, k, cells

    k = model%mesh%nlevels + 1
    do while (model%mesh%interface_depth(1, k) < 60.0_real64)
      k = k - 1
    end do
    least = huge(least)
    most = -huge(most)
    cells = 0
    do c = 1, model%mesh%ncolumns
      associate (v => model%mesh%triangle(:, c))
        if (minval(model%mesh%lat(v)) > 15.001_real64 .or. any(abs(model%mesh%lon(v) + 35.0_real64) > 15.0_real64)) cycle
      end associate
      cells = cells + 1
      speed = model%flow%upward(c, k) / model%mesh%area(c)
      least = min(least, speed)
      most = max(most, speed)
    end do
    write (output_unit, '(a, 2es10.2)') 'along the southern coast: least and largest speed upwards (m/s):', least, most
    call expect('a row of cells with two shapes of contact', cells > 20)
    call expect('water rises evenly along the coast', least > 0.0_real64 .and. most < 1.25_real64 * least)
  end subroutine check_coastal_row

  !> The northward transport falls off from the western coast by e over drag / beta; the current is
  !! taken less Sverdrup's. At the latitude of the strongest curl.
  subroutine check_boundary_current(model)
    type(model_type), intent(in) :: model
    real(real64), parameter :: lat = 25.0_real64
    real(real64) :: x(65), psi(65), v(64), interior, distance, exact
    integer :: i, j, n

    n = 0                                                ! a row of vertices, from the west
    j = 1
    do i = 1, model%mesh%nv
      if (abs(model%mesh%lat(i) - lat) > 0.1_real64) cycle
      n = n + 1
      x(n) = earth_radius * cos(radians(model%mesh%lat(i))) * radians(model%mesh%lon(i) + 60.0_real64)
      psi(n) = model%transport%psi(i)
      j = i
    end do
    call expect('a row of vertices', n == 65)
    v = (psi(2:) - psi(:64)) / (x(2:) - x(:64))
    interior = model%wind%curl(model%mesh%lat(j)) / (density * beta(model%mesh%lat(j)))
    v = log((v - interior) / (v(1) - interior))
    do i = 1, 64
      if (v(i) < -1.0_real64) exit
    end do
    associate (middle => 0.5_real64 * (x(2:) + x(:64)))
      distance = (-1.0_real64 - v(i - 1)) / (v(i) - v(i - 1)) * (middle(i) - middle(i - 1)) + middle(i - 1) - middle(1)
    end associate
    exact = drag / beta(model%mesh%lat(j))
    write (output_unit, '(a, 2f8.1)') 'boundary current: width and drag / beta (km):', distance / 1.0e3_real64, &
        exact / 1.0e3_real64
    ! Meridional gradients and cells of a third of the width.
    call expect_near('Stommel''s width', distance, exact, 0.1_real64 * exact)
  end subroutine check_boundary_current

  !> A month of the whole ocean over its bottom: water, heat and an even temperature are kept, the
  !! temperature within its first bounds, no water flows through coasts and floor.
  subroutine check_atlantic()
    type(model_type) :: model
    real(real64) :: low, high, through
    integer :: i

    call model%start(atlantic(), 8)
    low = minval(model%heat%t)
    high = maxval(model%heat%t)
    do i = 1, 30
      call model%advance()
    end do
    call expect_near('the Atlantic loses no water', model%flow%imbalance(model%mesh), 0.0_real64, 1.0e-13_real64)
    call expect_near('nor heat', model%heat_error(), 0.0_real64, 1.0e-12_real64)
    call expect('the temperature keeps its bounds', minval(model%heat%t) >= low - 1.0e-9_real64 .and. &
                maxval(model%heat%t) <= high + 1.0e-9_real64)
    through = 0.0_real64
    do i = 1, model%mesh%nv
      if (model%mesh%on_coast(i)) through = max(through, abs(dot_product(model%mesh%coast_normal(:, i), &
                                                                         model%flow%velocity(1:2, i))))
    end do
    call expect('nothing flows through the coast', through < 1.0e-15_real64)
    call expect('nor through the surface', &
                .not. any(abs(model%flow%velocity(3, size(model%mesh%lon) - model%mesh%nv + 1:)) > 0.0_real64))
    model%heat%t = 7.0_real64
    call model%advance()
    call expect_near('an even temperature stays even', maxval(abs(model%heat%t - 7.0_real64)), 0.0_real64, 1.0e-11_real64)
    call expect('the gyre turns clockwise in the south', maxval(model%transport%psi) < 60.0e6_real64 .and. &
                minval(model%transport%psi) < -5.0e6_real64)
  end subroutine check_atlantic

  subroutine expect(what, holds)
    character(len=*), intent(in) :: what
    logical, intent(in) :: holds
    if (holds) return
    write (error_unit, '(2a)') 'failed: ', what
    failures = failures + 1
  end subroutine expect

  subroutine expect_near(what, found, expected, tolerance)
    character(len=*), intent(in) :: what
    real(real64), intent(in) :: found, expected, tolerance
    if (abs(found - expected) <= tolerance) return
    write (error_unit, '(2a, 3(a, es23.15))') 'failed: ', what, ': ', found, ', expected ', expected, &
        ' within ', tolerance
    failures = failures + 1
  end subroutine expect_near

end program gyre_check

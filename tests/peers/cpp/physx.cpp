// The task side of PhysX, which its Rust bindings do not reach: an update on worker threads.
#include <PxPhysicsAPI.h>

using namespace physx;

namespace
{

// The continuation of an update: wakes the caller.
class Done : public PxLightCpuTask
{
public:
	void run() override
	{
	}
	void release() override
	{
		PxLightCpuTask::release();
		m_sync.set();
	}
	const char* getName() const override
	{
		return "done";
	}
	void wait()
	{
		m_sync.wait();
		m_sync.reset();
	}

private:
	PxSync m_sync;
};

struct Tasks
{
	PxDefaultCpuDispatcher* dispatcher;
	PxTaskManager* manager;
	Done done;
};

} // namespace

extern "C" void* physx_tasks_start(uint32_t threads)
{
	Tasks* tasks = new Tasks;
	tasks->dispatcher = PxDefaultCpuDispatcherCreate(threads);
	tasks->manager = PxTaskManager::createTaskManager(*PxGetErrorCallback(), tasks->dispatcher);
	return tasks;
}

extern "C" void physx_tasks_update(void* state, PxBroadPhase* broadPhase, const PxBroadPhaseUpdateData* data)
{
	Tasks* tasks = static_cast<Tasks*>(state);
	tasks->done.setContinuation(*tasks->manager, nullptr);
	broadPhase->update(*data, &tasks->done);
	tasks->done.removeReference();
	tasks->done.wait();
}

extern "C" void physx_tasks_stop(void* state)
{
	Tasks* tasks = static_cast<Tasks*>(state);
	tasks->manager->release();
	tasks->dispatcher->release();
	delete tasks;
}
